"""Nut positions of a measurement that stays a while at each.

    x_c = x_1 + n d,   n = ⌊t/T⌋ up to N - 1

Source: Hanifzadegan 2014, sec. 3.5.1 (every 5 mm from 0.2 to 0.6 m).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The stations follow the clock alone."""


class Output(NamedTuple):
    x_c: Annotated[float, Var("m", "nut distance from the thrust bearing")]


class Parameters(NamedTuple):
    x_1: Annotated[float, Var("m", "first position", min=0)] = 0.2
    d: Annotated[float, Var("m", "distance of the positions")] = 5e-3
    T: Annotated[float, Var("s", "time at each", min=1e-6)] = 0.9
    N: Annotated[float, Var("1", "number of positions", min=1)] = 81.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the position of this sample."""
    n = np.minimum(np.floor(x.k / tick_of(p.T, T_s)), p.N - 1)
    return State(x.k + 1), Output(p.x_1 + p.d * n)


model = Sampled(
    "Stations", step, State(), Input(), Parameters(), period=Fraction(3, 50_000)
)
