"""Multisine for measuring a two-input drive, on one motor after the other.

    d_i = A Σ_n sin(2π (f_0 + n Δf)(t - t_i) + φ_n),   n = 0 ... 90,
          t_i <= t < t_i + T_on,      φ_n = -π n²/91

Schroeder's phases keep the peak low; with f_0 a multiple of Δf the signal repeats
every 1/Δf.
Source: Gordon 2010, sec. 4.3.3 (responses from 60 to 150 Hz; the excitation is not
described); M. R. Schroeder, IEEE Trans. Information Theory 16 (1970) 85-89.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of, turn

LINES = 91


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    d_1: Annotated[float, Var("V", "excitation of the left motor")]
    d_2: Annotated[float, Var("V", "excitation of the right motor")]


class Parameters(NamedTuple):
    A: Annotated[float, Var("V", "amplitude of every line")] = 0.05
    f_0_hz: Annotated[float, Var("Hz", "lowest line", min=0)] = 60.0
    spacing_hz: Annotated[float, Var("Hz", "distance of the lines", min=0)] = 1.0
    t_1: Annotated[float, Var("s", "left motor begins", min=0)] = 0.0
    t_2: Annotated[float, Var("s", "right motor begins", min=0)] = 1.5
    T_on: Annotated[float, Var("s", "duration of each", min=0)] = 1.5


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the excitation of this sample."""
    left, right = x.k - tick_of(p.t_1, T_s), x.k - tick_of(p.t_2, T_s)
    length = tick_of(p.T_on, T_s)
    on_left = np.logical_and(left >= 0, left < length)
    on_right = np.logical_and(right >= 0, right < length)
    k = np.where(on_right, right, left)
    wave: Any = 0.0
    for n in range(LINES):
        cycles = turn(p.f_0_hz + n * p.spacing_hz, k, T_s)
        wave = wave + np.sin(2 * np.pi * (cycles - n * n / (2 * LINES)))
    wave = p.A * wave
    d_1: Any = np.where(on_left, wave, 0.0)
    d_2: Any = np.where(on_right, wave, 0.0)
    return State(x.k + 1), Output(d_1, d_2)


model = Sampled(
    "Multisine",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
