"""Trajectory pre-filter: offsets the command by the error it predicts.

    x_r' = x_r + K_vel v_f + K_acc a_f + K_jerk j_f + K_snap s_f

    v_f = G² s x_r,  a_f = G³ s² x_r,  j_f = G⁴ s³ x_r,  s_f = G⁵ s⁴ x_r,
    G = ω_c / (s + ω_c)

Each stage is pole-zero matched.  With all gains zero x_r' is x_r bit by bit,
and v_f ... s_f are the regressors of the identification.
Source: Gordon 2010, eq. 3.16 to 3.20; ω_c = 80 Hz.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.filters._sections import LowPass, low_pass, smoothed
from fmus.model import Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0
    D_1: Annotated[float, Var("rad/s", "previous G s x_r")] = 0.0
    D_2: Annotated[float, Var("rad/s2", "previous (G s)² x_r")] = 0.0
    D_3: Annotated[float, Var("rad/s3", "previous (G s)³ x_r")] = 0.0
    D_4: Annotated[float, Var("rad/s4", "previous (G s)⁴ x_r")] = 0.0
    w_1: Annotated[float, Var("rad/s", "memory of the last low-pass of v_f")] = 0.0
    w_2: Annotated[float, Var("rad/s2", "memory of the last low-pass of a_f")] = 0.0
    w_3: Annotated[float, Var("rad/s3", "memory of the last low-pass of j_f")] = 0.0
    w_4: Annotated[float, Var("rad/s4", "memory of the last low-pass of s_f")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0


class Output(NamedTuple):
    x_f: Annotated[float, Var("rad", "pre-filtered command x_r'")]
    v_f: Annotated[float, Var("rad/s", "filtered velocity command")]
    a_f: Annotated[float, Var("rad/s2", "filtered acceleration command")]
    j_f: Annotated[float, Var("rad/s3", "filtered jerk command")]
    s_f: Annotated[float, Var("rad/s4", "filtered snap command")]


class Gains(NamedTuple):
    """The parameters as a whole controller includes them."""

    K_vel: Annotated[float, Var("s", "pre-filter gain on the velocity")] = 0.0
    K_acc: Annotated[float, Var("s2", "pre-filter gain on the acceleration")] = 0.0
    K_jerk: Annotated[float, Var("s3", "pre-filter gain on the jerk")] = 0.0
    K_snap: Annotated[float, Var("s4", "pre-filter gain on the snap")] = 0.0
    omega_c_hz: Annotated[float, Var("Hz", "low-pass of the pre-filter", min=0)] = 80.0


class Parameters(NamedTuple):
    K_vel: Annotated[float, Var("s", "gain on the velocity")] = 0.0
    K_acc: Annotated[float, Var("s2", "gain on the acceleration")] = 0.0
    K_jerk: Annotated[float, Var("s3", "gain on the jerk")] = 0.0
    K_snap: Annotated[float, Var("s4", "gain on the snap")] = 0.0
    omega_c_hz: Annotated[float, Var("Hz", "pole of the low-pass", min=0)] = 80.0


def prepare(p: Parameters, T_s: float) -> LowPass:
    """Match the low-pass at the sample time."""
    return low_pass(2 * np.pi * p.omega_c_hz, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Return the pre-filtered command and its filtered derivatives."""
    D_1 = d.p * x.D_1 + d.gain * ((u.x_r - x.x_r) / T_s)
    D_2 = d.p * x.D_2 + d.gain * ((D_1 - x.D_1) / T_s)
    D_3 = d.p * x.D_3 + d.gain * ((D_2 - x.D_2) / T_s)
    D_4 = d.p * x.D_4 + d.gain * ((D_3 - x.D_3) / T_s)
    w_1, v_f = smoothed(x.w_1, D_1, d)
    w_2, a_f = smoothed(x.w_2, D_2, d)
    w_3, j_f = smoothed(x.w_3, D_3, d)
    w_4, s_f = smoothed(x.w_4, D_4, d)
    offset = p.K_vel * v_f + p.K_acc * a_f + p.K_jerk * j_f + p.K_snap * s_f
    x_next = State(u.x_r, D_1, D_2, D_3, D_4, w_1, w_2, w_3, w_4)
    return x_next, Output(u.x_r + offset, v_f, a_f, j_f, s_f)


model = Sampled(
    "Prefilter",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
