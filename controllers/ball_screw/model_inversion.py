"""Model inversion: the control signal that moves the model as commanded.

    G_ff(s) = (m_1 m_2 s⁴ + a_1 s³ + a_2 s² + a_3 s) / (c s + k),     u_ff = G_ff x_r

    a_1 = m_1 b_2 + m_2 b_1 + (m_1 + m_2) c
    a_2 = b_1 b_2 + (b_1 + b_2) c + (m_1 + m_2) k
    a_3 = (b_1 + b_2) k

Improper, hence pole-zero matched with three delays: zeros at 1, a = exp(r T_s) of
the real root r, and Q(z) of the axial pair; p = exp(-k T_s / c):

    G_ff(z) = g z⁻³ (z - 1) (z - a) Q(z) / (z - p),    T_s G_ff / (z - 1) → a_3 / k

Evaluated factor by factor, differences first: it is a fourth difference times
3e8 V/rad, and its coefficients nearly cancel.

``analytic`` takes the derivatives of the trajectory instead, without delay:
u_ff = (m_1 m_2 s_r + a_1 j_r + a_2 a_r + a_3 v_r) / k filtered by 1 / (1 + (c/k) s).
Source: Gordon 2010, eq. 3.4, 3.13 and sec. 3.2.3.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.ball_screw._drive import TwoMass
from controllers.ball_screw.rotary_command import nut_pole
from controllers.filters._sections import LowPass, Pair, low_pass, pair, smoothed
from fmus.model import Included, Sampled, Var

NEWTON_STEPS = 20


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0
    dx_r: Annotated[float, Var("rad", "previous difference of the command")] = 0.0
    f: Annotated[float, Var("rad", "previous dx_r filtered by z - a")] = 0.0
    df: Annotated[float, Var("rad", "previous difference of f")] = 0.0
    u_ff: Annotated[float, Var("V", "previous feed-forward")] = 0.0
    w: Annotated[float, Var("V", "memory of the analytic variant")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    v_r: Annotated[float, Var("rad/s", "commanded velocity")] = 0.0
    a_r: Annotated[float, Var("rad/s2", "commanded acceleration")] = 0.0
    j_r: Annotated[float, Var("rad/s3", "commanded jerk")] = 0.0
    s_r: Annotated[float, Var("rad/s4", "commanded snap")] = 0.0


class Output(NamedTuple):
    u_ff: Annotated[float, Var("V", "feed-forward")]


class Parameters(NamedTuple):
    drive: Annotated[TwoMass, Included()] = TwoMass()
    on: Annotated[bool, Var("1", "off: no feed-forward")] = True
    analytic: Annotated[bool, Var("1", "use the trajectory's derivatives")] = False


class Derived(NamedTuple):
    a_1: Any
    a_2: Any
    a_3: Any
    lag: Any  # 1 - a
    axial: Pair
    nut: LowPass
    g: Any


def denominator(p: TwoMass) -> tuple[Any, Any, Any]:
    """Return a_1, a_2, a_3 of eq. 3.4 (in V²s³/rad², V²s²/rad², V²s/rad²)."""
    m, b = p.m_1 + p.m_2, p.b_1 + p.b_2
    a_1 = p.m_1 * p.b_2 + p.m_2 * p.b_1 + m * p.c
    return a_1, p.b_1 * p.b_2 + b * p.c + m * p.k, b * p.k


def roots(p: TwoMass) -> tuple[Any, Any, Any]:
    """Split s³ + … = (s + r)(s² + q_1 s + q_0); returns r, q_1, q_0.

    -r is the root nearest to zero: 0.07 Hz, viscous friction against all inertia.
    """
    a_1, a_2, a_3 = (a / (p.m_1 * p.m_2) for a in denominator(p))
    r = a_3 / a_2
    for _ in range(NEWTON_STEPS):
        value = ((-r + a_1) * -r + a_2) * -r + a_3
        r = r + value / ((-3 * r + 2 * a_1) * -r + a_2)
    q_1 = a_1 - r
    return r, q_1, a_2 - r * q_1


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match zeros, pole and gain at the sample time."""
    drive = p.drive
    r, q_1, q_0 = roots(drive)
    axial = pair(q_1, q_0, T_s)
    nut = low_pass(nut_pole(drive.k, drive.c), T_s)
    lag = -np.expm1(-r * T_s)
    # a_3 / lag without 0/0 where nothing brakes the drive
    damped = r > 0
    ratio = np.where(damped, np.where(damped, r, 1.0) / np.where(damped, lag, 1.0), 0.0)
    ratio = np.where(damped, ratio, 1 / T_s)
    m_1, m_2 = drive.m_1, drive.m_2
    g = m_1 * m_2 * q_0 * ratio * nut.gain / (drive.k * T_s * axial.beta)
    return Derived(*denominator(drive), lag, axial, nut, g)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the feed-forward of this sample."""
    dx_r = u.x_r - x.x_r
    f = (dx_r - x.dx_r) + d.lag * x.dx_r
    df = f - x.f
    q = (df - x.df) + d.axial.alpha * x.df + d.axial.beta * (x.f - x.df)
    matched = d.nut.p * x.u_ff + d.g * q

    rigid = d.a_2 * u.a_r + d.a_3 * u.v_r
    m_1, m_2, *_, k, _ = p.drive
    force = (m_1 * m_2 * u.s_r + d.a_1 * u.j_r + rigid) / k
    w, smooth = smoothed(x.w, force, d.nut)
    u_ff: Any = np.where(p.on, np.where(p.analytic, smooth, matched), 0.0)
    return State(u.x_r, dx_r, f, df, matched, w), Output(u_ff)


model = Sampled(
    "ModelInversion",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
