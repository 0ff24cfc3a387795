"""Filter pack of the x axis: three notches and a low-pass, feed-forward after it.

    u = ω_lpf/(s + ω_lpf) ∏ (s² + 2ζ_N ω_N s + ω_N²)/(s² + 2ζ_D ω_N s + ω_N²) v + u_ff

Pole-zero matched.
Source: Gordon 2010, sec. 4.4.1.
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
    w_31: Annotated[float, Var("V", "first memory of the third notch")] = 0.0
    w_32: Annotated[float, Var("V", "second memory of the third notch")] = 0.0
    w_lpf: Annotated[float, Var("V", "memory of the low-pass")] = 0.0


class Input(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")] = 0.0
    u_ff: Annotated[float, Var("V", "feed-forward")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]


class Parameters(NamedTuple):
    omega_N1_hz: Annotated[float, Var("Hz", "first notch", min=0)] = 186.0
    zeta_N1: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.6
    zeta_D1: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7
    omega_N2_hz: Annotated[float, Var("Hz", "second notch", min=0)] = 332.0
    zeta_N2: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.3
    zeta_D2: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7
    omega_N3_hz: Annotated[float, Var("Hz", "third notch", min=0)] = 404.0
    zeta_N3: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.2
    zeta_D3: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7
    omega_lpf_hz: Annotated[float, Var("Hz", "low-pass pole", min=0)] = 1200.0


class Derived(NamedTuple):
    notch_1: Section
    notch_2: Section
    notch_3: Section
    lpf: LowPass


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match the four sections at the sample time."""
    return Derived(
        notch(p.omega_N1_hz, p.zeta_N1, p.zeta_D1, T_s),
        notch(p.omega_N2_hz, p.zeta_N2, p.zeta_D2, T_s),
        notch(p.omega_N3_hz, p.zeta_N3, p.zeta_D3, T_s),
        low_pass(2 * np.pi * p.omega_lpf_hz, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Filter the feedback signal and add the feed-forward."""
    w_11, w_12, v = filtered(x.w_11, x.w_12, u.v, d.notch_1)
    w_21, w_22, v = filtered(x.w_21, x.w_22, v, d.notch_2)
    w_31, w_32, v = filtered(x.w_31, x.w_32, v, d.notch_3)
    w_lpf, v = smoothed(x.w_lpf, v, d.lpf)
    return State(w_11, w_12, w_21, w_22, w_31, w_32, w_lpf), Output(v + u.u_ff)


model = Sampled(
    "GantryXFilters",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
