"""Bipod mechanism: two sliders on a rail carry the tool table by parallel rods.

    sin φ = (x_2 - x_1 - a_s)/(2 L_s),     φ̇ = (ẋ_2 - ẋ_1)/(2 L_s cos φ)
    H_1 ẍ_1 + H_12 ẍ_2 + b_x ẋ_1 - C_φ w + C_m w² + G = f_1 + f_d tan φ/2
    H_12 ẍ_1 + H_2 ẍ_2 + b_x ẋ_2 + C_φ w - C_m w² - G = f_2 - f_d tan φ/2
    H_1 ẍ_1 + C_d ẋ_1 + C_m ẋ_1² + G = f_1 + f_d tan φ/2       if x_2 is fixed

where w = ẋ_2 - ẋ_1 and

    m_a = m_1 + m_3/4 + 9Σm_s/16 - m_s/2,    m_b = ΣJ_s/(2L_s²) + (m_3/2 + Σm_s/8) sin²φ
    m_c = m_2 + m_3/4 + Σm_s/16 + m_s/2,     m_d = m_3/4 + 3Σm_s/16
    H_1 = m_a + h,   H_2 = m_c + h,   H_12 = m_d - h,   h = m_b/(2cos²φ)
    C_m = ½ dH_1/dx_1 = -m_e tan φ(1 + tan²φ)/(8L_s cos φ)
    m_e = m_3 + Σm_s/4 + ΣJ_s/L_s²
    C_φ = b_φ(1 + tan²φ)/(4L_s²),   C_d = b_x + C_φ
    G = -½(m_3 + Σm_s/2) g tan φ

so that ½(H_1 ẋ_1² + 2H_12 ẋ_1ẋ_2 + H_2 ẋ_2²) is the kinetic energy.  The tool table
hangs at y = L_s cos φ from the rail, where gravity and f_d push it away from.

Source: Hanifzadegan 2014, sec. 7.2.1, eq. 7.6 to 7.10, Table 7.1 (m_3 in kg, printed
Hz).  Corrected there: (7.10) prints 4 for 8 in C_m and squares the bracket of C_d,
both against the energy (docs/studies/bipod_lpv.md).
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Links(NamedTuple):
    """Parameters of the mechanism (Table 7.1)."""

    m_1: Annotated[float, Var("kg", "mass of slider T1", min=1e-3)] = 25.36
    m_2: Annotated[float, Var("kg", "mass of slider T2", min=1e-3)] = 22.67
    m_3: Annotated[float, Var("kg", "mass of tool table T3", min=0)] = 10.56
    m_s: Annotated[float, Var("kg", "mass of each of three rods", min=0)] = 4.16
    J_s: Annotated[float, Var("kg.m2", "inertia of each rod", min=0)] = 0.37
    L_s: Annotated[float, Var("m", "length of the rods", min=1e-3)] = 0.7
    a_s: Annotated[float, Var("m", "offset of the joints")] = 0.125
    b_x: Annotated[float, Var("N.s/m", "viscous friction of a slider", min=0)] = 50.0
    b_phi: Annotated[float, Var("N.m.s/rad", "friction of the joints", min=0)] = 10.0


def inertia(t: Any, p: Links) -> Any:
    """Return H_1 (kg) at t = tan φ: a constant plus a multiple of t²."""
    return p.m_1 + p.m_3 / 4 + 27 * p.m_s / 16 - p.m_s / 2 + turning(t, p)


def inertia_2(t: Any, p: Links) -> Any:
    """Return H_2 (kg) at t = tan φ."""
    return p.m_2 + p.m_3 / 4 + 3 * p.m_s / 16 + p.m_s / 2 + turning(t, p)


def coupling(t: Any, p: Links) -> Any:
    """Return H_12 (kg) at t = tan φ."""
    return p.m_3 / 4 + 9 * p.m_s / 16 - turning(t, p)


def turning(t: Any, p: Links) -> Any:
    """Return h (kg) at t = tan φ: what rods and tool table add as φ changes."""
    rods, lifting = 3 * p.J_s / (2 * p.L_s**2), p.m_3 / 2 + 3 * p.m_s / 8
    return (rods * (1 + t * t) + lifting * t * t) / 2


def effective_mass(p: Links) -> Any:
    """Return m_e (kg), by which H_1 grows with φ."""
    return p.m_3 + 3 * p.m_s / 4 + 3 * p.J_s / p.L_s**2


def convective(t: Any, p: Links) -> Any:
    """Return C_m (kg/m) at t = tan φ, |φ| < π/2."""
    return -effective_mass(p) * t * (1 + t * t) ** 1.5 / (8 * p.L_s)


def joints(t: Any, p: Links) -> Any:
    """Return C_φ (N s/m) at t = tan φ, of the speed at which the sliders part."""
    return p.b_phi * (1 + t * t) / (4 * p.L_s**2)


def damping(t: Any, p: Links) -> Any:
    """Return C_d (N s/m) at t = tan φ."""
    return p.b_x + joints(t, p)


def hanging(p: Links) -> Any:
    """Return the mass (kg) that moves with y."""
    return p.m_3 + 3 * p.m_s / 2


def weight(t: Any, p: Links, g: Any = 9.81) -> Any:
    """Return the size of G (N): what the tool table and rods weigh on T1."""
    return hanging(p) * g * t / 2


def distance(t: Any, p: Links) -> Any:
    """Return y (m), from the rail to the tool table, at t = tan φ."""
    return p.L_s / np.sqrt(1 + t * t)


def tangent(x_1: Any, x_2: Any, p: Links) -> Any:
    """Return tan φ from the positions of both sliders (m), |φ| up to 89.4 deg."""
    sine = (x_2 - x_1 - p.a_s) / (2 * p.L_s)
    return sine / np.sqrt(np.maximum(1 - sine * sine, 1e-4))
