"""Velocity loop of the P-PI cascade, closed on the rotary encoder.

    v_e = v_c - D y_1,    v = K_pv v_e + K_iv ∫v_e

D y[k] = (y[k] - y[k-1]) / T_s; the integral is that of backward rectangles.
Source: Gordon 2010, fig. 3.9, eq. 3.25; the gains are not published (set A).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    y_1: Annotated[float, Var("rad", "previous screw angle")] = 0.0
    v_ei: Annotated[float, Var("rad", "integral of the velocity error")] = 0.0


class Input(NamedTuple):
    v_c: Annotated[float, Var("rad/s", "velocity command")] = 0.0
    y_1: Annotated[float, Var("rad", "rotary encoder")] = 0.0


class Output(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")]


class Parameters(NamedTuple):
    K_pv: Annotated[float, Var("V.s/rad", "velocity gain")] = 0.91
    K_iv: Annotated[float, Var("V/rad", "integral gain")] = 119.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the feedback signal of this sample."""
    v_e = u.v_c - (u.y_1 - x.y_1) / T_s
    v_ei = x.v_ei + T_s * v_e
    return State(u.y_1, v_ei), Output(p.K_pv * v_e + p.K_iv * v_ei)


model = Sampled(
    "VelocityPI",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
