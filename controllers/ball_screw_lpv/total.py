"""Sum of the parts' commands, where tracking, vibration control and observer meet.

    v_m = v_t + v_v - d̂

Source: Hanifzadegan 2014, fig. 4.1.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    """A sum has no memory."""


class Input(NamedTuple):
    v_t: Annotated[float, Var("V", "command for tracking")] = 0.0
    v_v: Annotated[float, Var("V", "command against vibration")] = 0.0
    d: Annotated[float, Var("V", "estimated disturbance")] = 0.0


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]


class Parameters(NamedTuple):
    """A sum has none."""


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the sum of this sample."""
    return x, Output(u.v_t + u.v_v - u.d)


model = Sampled(
    "CommandSum", step, State(), Input(), Parameters(), period=Fraction(9, 25_000)
)
