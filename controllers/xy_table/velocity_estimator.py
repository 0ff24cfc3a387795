"""Velocity estimators V_est of a cascade that measures position.

    backward difference     V_est = (y[k] - y[k-1]) / T_s
    measured                V_est = v, the pure derivative s
    filtered                either, behind ω_c / (s + ω_c), pole-zero matched

Source: Anang et al. 2018, fig. 2 (V_est is drawn, not specified).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters._sections import LowPass, low_pass, smoothed
from fmus.model import Sampled, Var


class State(NamedTuple):
    y: Annotated[float, Var("mm", "previous position")] = 0.0
    w: Annotated[float, Var("mm/s", "memory of the low-pass")] = 0.0


class Input(NamedTuple):
    y: Annotated[float, Var("mm", "position")] = 0.0
    v: Annotated[float, Var("mm/s", "measured velocity")] = 0.0


class Output(NamedTuple):
    v_est: Annotated[float, Var("mm/s", "estimated velocity")]


class Parameters(NamedTuple):
    measured: Annotated[bool, Var("1", "take v, not differences of y")] = False
    filtered: Annotated[bool, Var("1", "low-pass the estimate")] = False
    omega_c_hz: Annotated[float, Var("Hz", "pole of the low-pass", min=0)] = 500.0


def prepare(p: Parameters, T_s: float) -> LowPass:
    """Match the low-pass at the sample time."""
    return low_pass(2 * np.pi * p.omega_c_hz, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Return the estimate of this sample."""
    rate: Any = np.where(p.measured, u.v, (u.y - x.y) / T_s)
    w, smooth = smoothed(x.w, rate, d)
    v_est: Any = np.where(p.filtered, smooth, rate)
    return State(u.y, w), Output(v_est)


model = Sampled(
    "VelocityEstimator",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
    prepare=prepare,
)
