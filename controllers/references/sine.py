"""Sine reference, at rest on its first value before it starts.

    x_r = A sin(2π f (t - t_0) + φ),   ẋ_r = 2π f A cos(2π f (t - t_0) + φ)

with ẋ_r = 0 before t_0.  Time is counted in ticks: the phase does not drift.
Source: test signal of Maeda 2007, ch. 4 and 6, and of position loops in general.
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


class Parameters(NamedTuple):
    amplitude: Annotated[float, Var("m", "amplitude A")] = 5e-3
    frequency_hz: Annotated[float, Var("Hz", "frequency f", min=0)] = 1.0
    phase: Annotated[float, Var("rad", "phase φ at the start")] = 0.0
    t_0: Annotated[float, Var("s", "rest before the sine", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the reference of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    angle = 2 * np.pi * turn(p.frequency_hz, np.maximum(k, 0), T_s) + p.phase
    omega = 2 * np.pi * p.frequency_hz
    v_r: Any = np.where(k >= 0, omega * p.amplitude * np.cos(angle), 0.0)
    return State(x.k + 1), Output(p.amplitude * np.sin(angle), v_r)


model = Sampled(
    "SineReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
