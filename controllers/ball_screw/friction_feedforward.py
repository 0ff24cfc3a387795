"""Friction feed-forward: the plant's own friction law at the commanded velocity.

    u_f = d(v_r)

Source: Gordon 2010, eq. 2.1 and sec. 3.2.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants.ball_screw._friction import Stribeck, friction

Parameters = Stribeck


class State(NamedTuple):
    """The law has no memory."""


class Input(NamedTuple):
    v_r: Annotated[float, Var("rad/s", "commanded velocity")] = 0.0


class Output(NamedTuple):
    u_f: Annotated[float, Var("V", "friction feed-forward")]


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the friction expected at the commanded velocity."""
    return x, Output(friction(u.v_r, p))


model = Sampled(
    "FrictionFeedforward",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
