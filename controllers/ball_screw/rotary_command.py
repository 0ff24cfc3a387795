"""Rotary command generator: the screw motion that the table command needs.

    G_r(s) = (m_2 s² + (b_2 + c) s + k) / (c s + k),      x_1r = G_r x_r

Improper, hence pole-zero matched with one delay: with the matched pair of zeros
Q(z) and p = exp(-k T_s / c),  G_r(z) = g z⁻¹ Q(z) / (z - p),  G_r(1) = 1.
Written as x_1r = x_r + δ in differences of x_r, so that no digits are lost.

``analytic`` takes the derivatives of the trajectory instead, without delay:
x_1r = x_r + (m_2 a_r + b_2 v_r) / k filtered by 1 / (1 + (c/k) s).
Source: Gordon 2010, eq. 3.12 and sec. 3.2.3.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters._sections import LowPass, Pair, low_pass, pair, smoothed
from fmus.model import Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0
    dx_r: Annotated[float, Var("rad", "previous difference of the command")] = 0.0
    delta: Annotated[float, Var("rad", "previous x_1r - x_r")] = 0.0
    w: Annotated[float, Var("rad", "memory of the analytic variant")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    v_r: Annotated[float, Var("rad/s", "commanded velocity")] = 0.0
    a_r: Annotated[float, Var("rad/s2", "commanded acceleration")] = 0.0


class Output(NamedTuple):
    x_1r: Annotated[float, Var("rad", "screw command")]


class Parameters(NamedTuple):
    m_2: Annotated[float, Var("V.s2/rad", "translating inertia", min=1e-9)] = 0.379e-3
    b_2: Annotated[float, Var("V.s/rad", "damping of the guideways", min=0)] = 0.0
    k: Annotated[float, Var("V/rad", "axial stiffness", min=1e-9)] = 210.02
    c: Annotated[float, Var("V.s/rad", "damping of the nut", min=0)] = 0.014
    on: Annotated[bool, Var("1", "off: the screw gets the table command")] = True
    analytic: Annotated[bool, Var("1", "use the trajectory's derivatives")] = False


class Derived(NamedTuple):
    zeros: Pair
    nut: LowPass
    g: Any


def nut_pole(k: Any, c: Any) -> Any:
    """Return k / c, the corner of 1 / (c s + k) in rad/s, also where c is zero."""
    return k / np.maximum(c, 1e-30)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match zeros, pole and gain at the sample time."""
    zeros = pair((p.b_2 + p.c) / p.m_2, p.k / p.m_2, T_s)
    nut = low_pass(nut_pole(p.k, p.c), T_s)
    return Derived(zeros, nut, nut.gain / zeros.beta)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the screw command of this sample."""
    dx_r = u.x_r - x.x_r
    delta = (
        d.nut.p * x.delta
        + d.g * (dx_r - x.dx_r)
        + (d.g * d.zeros.alpha - d.nut.gain) * x.dx_r
        - dx_r
    )
    w, wind_up = smoothed(x.w, (p.m_2 * u.a_r + p.b_2 * u.v_r) / p.k, d.nut)
    offset: Any = np.where(p.analytic, wind_up, delta)
    x_1r: Any = u.x_r + np.where(p.on, offset, 0.0)
    return State(u.x_r, dx_r, delta, w), Output(x_1r)


model = Sampled(
    "RotaryCommand",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
