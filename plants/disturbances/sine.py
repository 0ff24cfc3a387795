"""Sine source for measuring frequency responses in a running loop.

    d = A sin 2π f (t - t_0),    t >= t_0

Source: Gordon 2010, sec. 3.2.1 (measured frequency responses of the drive).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import sine, tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    d: Annotated[float, Var("V", "excitation")]


class Parameters(NamedTuple):
    A: Annotated[float, Var("V", "amplitude")] = 0.1
    f_hz: Annotated[float, Var("Hz", "frequency", min=0)] = 100.0
    t_0: Annotated[float, Var("s", "rest before the sine", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the excitation of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    d: Any = np.where(k >= 0, p.A * sine(p.f_hz, k, T_s), 0.0)
    return State(x.k + 1), Output(d)


model = Sampled(
    "Excitation",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
