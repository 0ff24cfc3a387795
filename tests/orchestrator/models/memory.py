"""Returns the input of its previous tick: no output depends on its input.

Source: none; a test of the master (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    kept: Annotated[float, Var("1", "input of the previous tick")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("1", "anything")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("1", "input of the previous tick")]


class Parameters(NamedTuple):
    """It has none."""


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return what was kept."""
    return State(u.u), Output(x.kept)


model = Sampled(
    "Memory", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
