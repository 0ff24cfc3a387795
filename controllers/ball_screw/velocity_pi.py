"""Velocity loop of the P-PI cascade, closed on the rotary encoder.

    v_e = v_c + D x_r - D y_1,    v = K_pv v_e + K_iv ∫v_e

D y[k] = (y[k] - y[k-1]) / T_s; the integral is that of backward rectangles.
Without the velocity feed-forward D x_r the drive lags by velocity over K_px.
Source: Gordon 2010, fig. 3.9, eq. 3.25; the gains are not published (set A).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0
    y_1: Annotated[float, Var("rad", "previous screw angle")] = 0.0
    v_ei: Annotated[float, Var("rad", "integral of the velocity error")] = 0.0


class Input(NamedTuple):
    v_c: Annotated[float, Var("rad/s", "velocity command")] = 0.0
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    y_1: Annotated[float, Var("rad", "rotary encoder")] = 0.0


class Output(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")]


class Parameters(NamedTuple):
    K_pv: Annotated[float, Var("V.s/rad", "velocity gain")] = 0.91
    K_iv: Annotated[float, Var("V/rad", "integral gain")] = 119.0
    velocity_feedforward: Annotated[bool, Var("1", "add D x_r to the command")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the feedback signal of this sample."""
    v_r: Any = np.where(p.velocity_feedforward, (u.x_r - x.x_r) / T_s, 0.0)
    v_e = u.v_c + v_r - (u.y_1 - x.y_1) / T_s
    v_ei = x.v_ei + T_s * v_e
    return State(u.x_r, u.y_1, v_ei), Output(p.K_pv * v_e + p.K_iv * v_ei)


model = Sampled(
    "VelocityPI",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
