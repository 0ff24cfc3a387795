"""Speed controller with limit and anti-windup, gains derived once.

    v = K_p e + q,  u = clip(v),  q⁺ = q + T_s K_i (e + (u - v)/K_p)

Source: any textbook (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    q: Annotated[float, Var("N.m", "integral torque")] = 0.0


class Input(NamedTuple):
    r: Annotated[float, Var("rad/s", "reference")] = 0.0
    y: Annotated[float, Var("rad/s", "measurement")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("N.m", "torque")]
    saturated: Annotated[float, Var("1", "1 when limited")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("N.m.s/rad", "gain", min=1e-9)] = 0.5
    K_i: Annotated[float, Var("N.m/rad", "integral gain", min=0)] = 20.0
    u_max: Annotated[float, Var("N.m", "limit", min=0)] = 1.0


class Derived(NamedTuple):
    gain: float
    windup: float


def prepare(p: Parameters, T_s: float) -> Derived:
    return Derived(T_s * p.K_i, 1 / p.K_p)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    e = u.r - u.y
    v = p.K_p * e + x.q
    limited = np.minimum(np.maximum(v, -p.u_max), p.u_max)
    q = x.q + d.gain * (e + d.windup * (limited - v))
    return State(q), Output(limited, np.where(np.fabs(v) > p.u_max, 1.0, 0.0))


model = Sampled(
    "SmallPI", step, State(), Input(), Parameters(), Fraction(1, 2000), prepare
)
