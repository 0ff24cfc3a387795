"""Sine reference that steps through frequencies: a frequency response in one run.

    x_r = A sin 2π f_j t,    j = ⌊t / T_d⌋ = 0 ... N - 1,   then 0
    f_j = f_1 (f_N / f_1)^{j/(N-1)}, rounded to a multiple of 2/T_d

Each frequency lasts T_d: the first half settles, the second half holds whole periods
and is what ``controllers.synthesis.stepped_sine`` reads.  No jump: every one begins
and ends at 0.
Source: Maeda 2007, sec. 4.1 and 4.2 (sine inputs of several amplitudes from 0.5 to
500 Hz); the dwell is ours.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of, turn


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The reference follows the clock alone."""


class Output(NamedTuple):
    x_r: Annotated[float, Var("m", "reference position")]
    v_r: Annotated[float, Var("m/s", "reference velocity")]
    f_hz: Annotated[float, Var("Hz", "frequency of this dwell")]


class Parameters(NamedTuple):
    amplitude: Annotated[float, Var("m", "amplitude A")] = 1e-6
    f_1: Annotated[float, Var("Hz", "first frequency", min=1e-9)] = 1.0
    f_N: Annotated[float, Var("Hz", "last frequency", min=1e-9)] = 500.0
    N: Annotated[float, Var("1", "number of frequencies", min=2)] = 24.0
    T_d: Annotated[float, Var("s", "time on each", min=1e-9)] = 2.0


def frequency(j: Any, p: Parameters) -> Any:
    """Return f_j (Hz)."""
    wanted = p.f_1 * (p.f_N / p.f_1) ** (j / (p.N - 1))
    return np.maximum(np.floor(wanted * p.T_d / 2 + 0.5), 1.0) * (2 / p.T_d)


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the reference of this sample."""
    dwell = tick_of(p.T_d, T_s)
    j = np.floor(x.k / dwell)
    f_hz = frequency(np.minimum(j, p.N - 1), p)
    angle = 2 * np.pi * turn(f_hz, x.k - j * dwell, T_s)
    A: Any = np.where(j < p.N, p.amplitude, 0.0)
    rate = 2 * np.pi * f_hz * A * np.cos(angle)
    return State(x.k + 1), Output(A * np.sin(angle), rate, f_hz)


model = Sampled(
    "SteppedSine",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
