"""Samples its input and hands it on: y = u.

Source: none; a test of the master (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    pass


class Input(NamedTuple):
    u: Annotated[float, Var("1", "what is sampled")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("1", "the latest sample")]


class Parameters(NamedTuple):
    pass


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    return x, Output(u.u)


model = Sampled("Hold", step, State(), Input(), Parameters(), Fraction(1, 2000))
