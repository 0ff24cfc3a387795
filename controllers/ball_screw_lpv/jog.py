"""Jogs for identification: a square command of rising amplitude, to and fro.

    v_m = V_n for T seconds, then -V_n for T seconds,   n = 1, 2, ... N,   then 0
    V_n = V_1 + (n - 1) dV

Source: Hanifzadegan 2014, sec. 3.4.1, fig. 3.11a (amplitudes and times by its axes).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The jogs follow the clock alone."""


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]


class Parameters(NamedTuple):
    V_1: Annotated[float, Var("V", "first amplitude")] = 1.2
    dV: Annotated[float, Var("V", "rise from jog to jog")] = 0.6
    T: Annotated[float, Var("s", "time in one direction", min=1e-6)] = 0.36
    N: Annotated[float, Var("1", "number of jogs", min=1)] = 4.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command of this sample."""
    half = np.floor(x.k / tick_of(p.T, T_s))
    n = np.floor(half / 2)
    sign = 1 - 2 * (half - 2 * n)
    v: Any = np.where(n < p.N, sign * (p.V_1 + n * p.dV), 0.0)
    return State(x.k + 1), Output(v)


model = Sampled(
    "Jogs", step, State(), Input(), Parameters(), period=Fraction(9, 25_000)
)
