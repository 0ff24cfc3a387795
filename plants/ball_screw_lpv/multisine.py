"""Multisine for measuring frequency responses of the drive in its loop.

    w = Σ_n sin(2π n f_1 t + φ_n),   n = 4 ... 108,   φ_n = -π m²/105,  m = n - 4
    f = F w,      r = r_0 + R w

11 to 300 Hz with f_1 = 25/9 Hz, whose period of 0.36 s holds whole numbers of
samples; Schroeder's phases keep the peak low.
Source: Hanifzadegan 2014, fig. 4.7, 5.6 (swept from 10 to 300 Hz), 5.7; M. R.
Schroeder, IEEE Trans. Information Theory 16 (1970) 85-89.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import turn

FIRST, LAST = 4, 108


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    f: Annotated[float, Var("N", "force")]
    r: Annotated[float, Var("m", "reference")]


class Parameters(NamedTuple):
    F: Annotated[float, Var("N", "amplitude of every line of the force")] = 2.0
    R: Annotated[float, Var("m", "amplitude of every line of the reference")] = 0.0
    r_0: Annotated[float, Var("m", "position around which it is measured")] = 0.25
    f_1_hz: Annotated[float, Var("Hz", "distance of the lines", min=0)] = 25 / 9


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return force and reference of this sample."""
    w: Any = 0.0
    for n in range(FIRST, LAST + 1):
        late = (n - FIRST) ** 2 / (2 * (LAST - FIRST + 1))
        w = w + np.sin(2 * np.pi * (turn(n * p.f_1_hz, x.k, T_s) - late))
    return State(x.k + 1), Output(p.F * w, p.r_0 + p.R * w)


model = Sampled(
    "DriveMultisine", step, State(), Input(), Parameters(), period=Fraction(3, 50_000)
)
