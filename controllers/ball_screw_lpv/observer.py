"""Disturbance observer: what force, in volts, explains the motion beside the command.

    d̂ = Q/Ĝ u_c - Q v_m
    Q = 1/(a_2 s² + a_1 s + 1),    Ĝ = k_v r_g²/(s (J_e s + B_e))

by Tustin's rule, k_v = k_t k_a/r_g; v_m is the whole command of the sample before,
as the present one is not known yet.
Source: Hanifzadegan 2014, eq. 4.14 and sec. 4.5.2 (Q); (4.15) lacks an inverse.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.ball_screw_lpv._tustin import Section, polynomial
from fmus.model import Sampled, Var


class State(NamedTuple):
    w_1: Annotated[float, Var("V", "memory")] = 0.0
    w_2: Annotated[float, Var("V", "memory")] = 0.0
    u_0: Annotated[float, Var("m", "first table position")] = 0.0
    started: Annotated[float, Var("1", "there is a first position")] = 0.0


class Input(NamedTuple):
    u_c: Annotated[float, Var("m", "table position")] = 0.0
    v_m: Annotated[float, Var("V", "whole command of the sample before")] = 0.0


class Output(NamedTuple):
    d: Annotated[float, Var("V", "estimated disturbance")]


class Parameters(NamedTuple):
    J_e: Annotated[float, Var("kg.m2", "inertia at the motor", min=1e-9)] = 7.1432e-4
    B_e: Annotated[float, Var("N.m.s/rad", "viscous damping", min=0)] = 0.0156
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = (
        0.020 / (2 * np.pi)
    )
    k_a: Annotated[float, Var("A/V", "gain of the current loop", min=1e-9)] = 0.887
    k_t: Annotated[float, Var("N.m/A", "torque constant", min=1e-9)] = 0.72
    a_2: Annotated[float, Var("s2", "of Q", min=0)] = 1e-5
    a_1: Annotated[float, Var("s", "of Q", min=0)] = 0.05


class Derived(NamedTuple):
    q: Section
    motion: Section


def prepare(p: Parameters, T_s: float) -> Derived:
    """Return denominator and numerators, as divided by the first coefficient."""
    q = polynomial(p.a_2, p.a_1, 1.0, T_s)
    k = p.k_t * p.k_a * p.r_g
    inverse = polynomial(p.J_e / k, p.B_e / k, 0.0, T_s)
    return Derived(q, inverse)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the estimate of this sample (direct form II transposed)."""
    u_0: Any = np.where(x.started > 0, x.u_0, u.u_c)
    moved = u.u_c - u_0
    q, g = d.q, d.motion
    y = (g.b_0 * moved - u.v_m) / q.b_0 + x.w_1
    w_1 = (g.b_1 * moved - 2 * u.v_m - q.b_1 * y) / q.b_0 + x.w_2
    w_2 = (g.b_2 * moved - u.v_m - q.b_2 * y) / q.b_0
    return State(w_1, w_2, u_0, 1.0), Output(y)


model = Sampled(
    "DisturbanceObserver",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(9, 25_000),
    prepare=prepare,
)
