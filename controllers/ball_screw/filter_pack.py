"""Filter pack: two notches and a low-pass on the feedback, feed-forward added after.

    u = G_fp v + u_ff + u_f

    G_fp = ω_lpf / (s + ω_lpf) · ∏ (s² + 2ζ_z ω_n s + ω_n²) / (s² + 2ζ_p ω_n s + ω_n²)

Pole-zero matched.  The feed-forward by-passes the filters (eq. 3.14).
Source: Gordon 2010, eq. 3.9, 3.10.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.filters._sections import (
    LowPass,
    Section,
    filtered,
    low_pass,
    notch,
    smoothed,
)
from fmus.model import Sampled, Var


class State(NamedTuple):
    w_11: Annotated[float, Var("V", "first memory of the first notch")] = 0.0
    w_12: Annotated[float, Var("V", "second memory of the first notch")] = 0.0
    w_21: Annotated[float, Var("V", "first memory of the second notch")] = 0.0
    w_22: Annotated[float, Var("V", "second memory of the second notch")] = 0.0
    w_lpf: Annotated[float, Var("V", "memory of the low-pass")] = 0.0


class Input(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")] = 0.0
    u_ff: Annotated[float, Var("V", "feed-forward")] = 0.0
    u_f: Annotated[float, Var("V", "friction feed-forward")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]


class Parameters(NamedTuple):
    omega_lpf_hz: Annotated[float, Var("Hz", "low-pass pole", min=0)] = 2000.0
    omega_n1_hz: Annotated[float, Var("Hz", "first notch", min=0)] = 420.0
    zeta_z1: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.55
    zeta_p1: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7
    omega_n2_hz: Annotated[float, Var("Hz", "second notch", min=0)] = 1080.0
    zeta_z2: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.05
    zeta_p2: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7


class Derived(NamedTuple):
    notch_1: Section
    notch_2: Section
    lpf: LowPass


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match the three sections at the sample time."""
    return Derived(
        notch(p.omega_n1_hz, p.zeta_z1, p.zeta_p1, T_s),
        notch(p.omega_n2_hz, p.zeta_z2, p.zeta_p2, T_s),
        low_pass(2 * np.pi * p.omega_lpf_hz, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Filter the feedback signal and add the feed-forward."""
    w_11, w_12, v = filtered(x.w_11, x.w_12, u.v, d.notch_1)
    w_21, w_22, v = filtered(x.w_21, x.w_22, v, d.notch_2)
    w_lpf, v = smoothed(x.w_lpf, v, d.lpf)
    return State(w_11, w_12, w_21, w_22, w_lpf), Output(v + u.u_ff + u.u_f)


model = Sampled(
    "FilterPack",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
