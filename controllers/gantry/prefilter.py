"""Trajectory pre-filters of the gantry, one set of gains for either end.

    y_if = y_r + K_vel,i v_f + K_acc,i a_f + K_jerk,i j_f + K_snap,i s_f

The filtered derivatives are those of ``controllers.filters.linear_prefilter``.
Source: Gordon 2010, eq. 4.32; ω_c = 80 Hz.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters import linear_prefilter
from controllers.filters._sections import LowPass, low_pass
from controllers.filters.linear_prefilter import State
from controllers.filters.prefilter import Parameters as Gains
from fmus.model import Sampled, Var


class Input(NamedTuple):
    y_r: Annotated[float, Var("m", "command")] = 0.0


class Output(NamedTuple):
    y_1f: Annotated[float, Var("m", "command of the left end")]
    y_2f: Annotated[float, Var("m", "command of the right end")]
    v_f: Annotated[float, Var("m/s", "filtered velocity command")]
    a_f: Annotated[float, Var("m/s2", "filtered acceleration command")]
    j_f: Annotated[float, Var("m/s3", "filtered jerk command")]
    s_f: Annotated[float, Var("m/s4", "filtered snap command")]


class Parameters(NamedTuple):
    K_vel_1: Annotated[float, Var("s", "left end, gain on the velocity")] = 0.0
    K_acc_1: Annotated[float, Var("s2", "left end, on the acceleration")] = 0.0
    K_jerk_1: Annotated[float, Var("s3", "left end, on the jerk")] = 0.0
    K_snap_1: Annotated[float, Var("s4", "left end, on the snap")] = 0.0
    K_vel_2: Annotated[float, Var("s", "right end, gain on the velocity")] = 0.0
    K_acc_2: Annotated[float, Var("s2", "right end, on the acceleration")] = 0.0
    K_jerk_2: Annotated[float, Var("s3", "right end, on the jerk")] = 0.0
    K_snap_2: Annotated[float, Var("s4", "right end, on the snap")] = 0.0
    omega_c_hz: Annotated[float, Var("Hz", "pole of the low-pass", min=0)] = 80.0


def prepare(p: Parameters, T_s: float) -> LowPass:
    """Match the low-pass at the sample time."""
    return low_pass(2 * np.pi * p.omega_c_hz, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Return the command of either end."""
    left = Gains(p.K_vel_1, p.K_acc_1, p.K_jerk_1, p.K_snap_1, p.omega_c_hz)
    x_next, y = linear_prefilter.step(x, linear_prefilter.Input(u.y_r), left, T_s, d)
    offset: Any = (
        p.K_vel_2 * y.v_f + p.K_acc_2 * y.a_f + p.K_jerk_2 * y.j_f + p.K_snap_2 * y.s_f
    )
    return x_next, Output(y.x_f, u.y_r + offset, y.v_f, y.a_f, y.j_f, y.s_f)


model = Sampled(
    "GantryPrefilter",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
