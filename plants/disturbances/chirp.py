"""Force whose frequency rises, over and over.

    f = F sin 2π(f_0 t + c t²),     t = time since t_0, from zero again every T

so that the frequency at t is f_0 + 2 c t.
Source: Hanifzadegan 2014, eq. 7.22 (200 N, 10 Hz, 17 Hz/s; 10 to 101 Hz in 2.68 s,
in words 90) and 7.4 (50 N, 20 Hz, 190 Hz/s, every second: 20 to 400 Hz).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    f: Annotated[float, Var("N", "force")]


class Parameters(NamedTuple):
    F: Annotated[float, Var("N", "amplitude")] = 200.0
    f_0_hz: Annotated[float, Var("Hz", "frequency at first", min=0)] = 10.0
    c: Annotated[float, Var("Hz/s", "half the rate of the frequency")] = 17.0
    T: Annotated[float, Var("s", "duration of one sweep", min=1e-9)] = 2.68
    t_0: Annotated[float, Var("s", "rest before the first", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the force of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    sweep = tick_of(p.T, T_s)
    t = (k - sweep * np.floor(k / sweep)) * T_s
    f: Any = np.where(k >= 0, p.F * np.sin(2 * np.pi * (p.f_0_hz + p.c * t) * t), 0.0)
    return State(x.k + 1), Output(f)


model = Sampled(
    "Chirp", step, State(), Input(), Parameters(), period=Fraction(1, 20_000)
)
