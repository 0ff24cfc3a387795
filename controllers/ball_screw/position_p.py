"""Position loop of the P-PI cascade, closed on the linear encoder.

    v_c = K_px (x_r - y_2)

The velocity feed-forward enters at the velocity loop, as in the figure: a position
loop that runs slower than it would hold back what the command demands.
Source: Gordon 2010, fig. 3.9, eq. 3.25; the gain is not published (set A).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    """The law has no memory."""


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    y_2: Annotated[float, Var("rad", "linear encoder as screw angle")] = 0.0


class Output(NamedTuple):
    v_c: Annotated[float, Var("rad/s", "velocity command")]


class Parameters(NamedTuple):
    K_px: Annotated[float, Var("1/s", "position gain")] = 189.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the velocity command of this sample."""
    return x, Output(p.K_px * (u.x_r - u.y_2))


model = Sampled(
    "PositionP",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
