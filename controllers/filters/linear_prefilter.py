"""Trajectory pre-filter of a linear axis: ``prefilter`` in metres.

    x_r' = x_r + K_vel v_f + K_acc a_f + K_jerk j_f + K_snap s_f

A run that begins away from zero begins with ``state.x_r`` there.
Source: Gordon 2010, eq. 4.20; ω_c = 80 Hz.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.filters import prefilter
from controllers.filters._sections import LowPass
from controllers.filters.prefilter import Parameters, prepare
from fmus.model import Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("m", "previous command")] = 0.0
    D_1: Annotated[float, Var("m/s", "previous G s x_r")] = 0.0
    D_2: Annotated[float, Var("m/s2", "previous (G s)² x_r")] = 0.0
    D_3: Annotated[float, Var("m/s3", "previous (G s)³ x_r")] = 0.0
    D_4: Annotated[float, Var("m/s4", "previous (G s)⁴ x_r")] = 0.0
    w_1: Annotated[float, Var("m/s", "memory of the last low-pass of v_f")] = 0.0
    w_2: Annotated[float, Var("m/s2", "memory of the last low-pass of a_f")] = 0.0
    w_3: Annotated[float, Var("m/s3", "memory of the last low-pass of j_f")] = 0.0
    w_4: Annotated[float, Var("m/s4", "memory of the last low-pass of s_f")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("m", "command")] = 0.0


class Output(NamedTuple):
    x_f: Annotated[float, Var("m", "pre-filtered command x_r'")]
    v_f: Annotated[float, Var("m/s", "filtered velocity command")]
    a_f: Annotated[float, Var("m/s2", "filtered acceleration command")]
    j_f: Annotated[float, Var("m/s3", "filtered jerk command")]
    s_f: Annotated[float, Var("m/s4", "filtered snap command")]


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Return the pre-filtered command and its filtered derivatives."""
    x_next, y = prefilter.step(prefilter.State(*x), prefilter.Input(u.x_r), p, T_s, d)
    return State(*x_next), Output(*y)


model = Sampled(
    "LinearPrefilter",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
