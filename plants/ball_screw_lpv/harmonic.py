"""Harmonic disturbance on the motor side, given as a voltage at the amplifier.

    f = (k_t k_a/r_g) V sin(ω (t - t_0)),    t >= t_0

Source: Hanifzadegan 2014, sec. 4.5.2 (3 V at 1350 rad/s) and 5.2.2 (1.8 and 1.3 V
at 1340 rad/s).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import sine, tick_of
from plants.ball_screw_lpv._drive import Amplifier
from plants.ball_screw_lpv._mode import R_G


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    f: Annotated[float, Var("N", "disturbance on the motor side")]
    v: Annotated[float, Var("V", "the same as a voltage")]


class Parameters(NamedTuple):
    V: Annotated[float, Var("V", "amplitude")] = 3.0
    omega: Annotated[float, Var("rad/s", "frequency", min=0)] = 1350.0
    t_0: Annotated[float, Var("s", "rest before the sine", min=0)] = 0.0
    amplifier: Amplifier = Amplifier()
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = R_G


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the disturbance of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    v: Any = np.where(k >= 0, p.V * sine(p.omega / (2 * np.pi), k, T_s), 0.0)
    return State(x.k + 1), Output(p.amplifier.k_t * p.amplifier.k_a / p.r_g * v, v)


model = Sampled(
    "HarmonicDisturbance",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(3, 50_000),
)
