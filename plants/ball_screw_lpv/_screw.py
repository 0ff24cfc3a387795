"""Hybrid model of the drive: lumped motor and table, a screw with its own mass.

The screw deforms linearly between thrust bearing and nut and moves as a body
beyond; its kinetic energy gives the mass matrix, springs in series the stiffness:

    1/k_e = 1/k_b + x_c/(E A) + 2/k_n + r_g²/k_c + r_g² x_c/(G J)
    k_1 = 1/(x_c/(E A) + 1/k_b),   k_tc = 1/(1/k_c + x_c/(G J))
    a = k_e/k_b, b = k_e/k_1,  q_0 = r_g² k_e/k_c, q_1 = r_g² k_e/k_tc,  p = 1 - q
    m_e  = ρA [x_c/3 (a² + a b + b²) + (l_s - x_c) b²],   J_1, J_2, J_12 likewise
    m_11 = (J_1 + J_m)/r_g² + m_e,  m_12 = J_12/r_g² - m_e,
    m_22 = J_2/r_g² + m_e + m_tab + m_wor
    M ü + C u̇ + k_e [1 -1; -1 1] u = (f_m, f_c),   C = diag(c_m/r_g², c_c) + C_hys

Structural loss η makes the springs of bearing, nut and coupling k (1 + jη); then
k_e = k̂ (1 + jη_e) and c_hys = η_e √(k̂ (m_11 m_22 - m_12²)/(m_11 + 2 m_12 + m_22)).

Source: Hanifzadegan 2014, eq. 3.9 to 3.16, A.12 to A.14, Table 3.1.  J_1 and J_12
are derived, as printed they are mangled; E, G, ρ are not printed; J_m and m_tab
give the printed M_s, η the printed c_hys (docs/studies/ball_screw_lpv.md).
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var
from plants.ball_screw_lpv._mode import R_G


class Screw(NamedTuple):
    """Parameters of the drive train (Table 3.1, completed)."""

    k_b: Annotated[float, Var("N/m", "stiffness of the thrust bearing", min=1)] = 1.13e8
    k_n: Annotated[float, Var("N/m", "stiffness of the nut, twice", min=1)] = 1.37e8
    k_c: Annotated[float, Var("N.m/rad", "stiffness of the coupling", min=1)] = 6500.0
    E_s: Annotated[float, Var("Pa", "Young's modulus of the screw", min=1)] = 2.08e11
    G_s: Annotated[float, Var("Pa", "shear modulus of the screw", min=1)] = 8.02e10
    rho_s: Annotated[float, Var("kg/m3", "density of the screw", min=1)] = 7850.0
    d_s: Annotated[float, Var("m", "diameter of the screw", min=1e-3)] = 0.020
    l_s: Annotated[float, Var("m", "length of the screw", min=1e-3)] = 0.82
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = R_G
    J_m: Annotated[float, Var("kg.m2", "inertia of motor and coupling", min=0)] = (
        3.7945e-4
    )
    m_tab: Annotated[float, Var("kg", "mass of table and nut", min=1e-3)] = 22.993
    c_m: Annotated[float, Var("N.m.s/rad", "viscous damping of the motor", min=0)] = (
        0.0156
    )
    c_c: Annotated[float, Var("N.s/m", "viscous damping of the guideways", min=0)] = 0.0
    eta: Annotated[float, Var("1", "structural loss factor", min=0)] = 0.0475


class Matrices(NamedTuple):
    """Masses (kg), stiffness (N/m), structural damping (kg/s) at one point."""

    m_11: Any
    m_12: Any
    m_22: Any
    k_e: Any
    c_hys: Any


def matrices(x_c: Any, m_wor: Any, p: Screw) -> Matrices:
    """Return M, K and the structural damping at nut position x_c (m).

    Stiffness is k̂, with the loss; at ``eta = 0`` it is k_e and c_hys vanishes.
    """
    area, polar = np.pi * p.d_s**2 / 4, np.pi * p.d_s**4 / 32
    r_2 = p.r_g * p.r_g
    bearing, coupling = 1 / p.k_b, r_2 / p.k_c
    joints = bearing + 2 / p.k_n + coupling
    stretch, twist = x_c / (p.E_s * area), r_2 * x_c / (p.G_s * polar)
    k_e = 1 / (joints + stretch + twist)

    def energy(f_0: Any, f_1: Any, g_0: Any, g_1: Any) -> Any:
        """∫ f g over the screw, both linear from 0 to x_c and constant beyond."""
        linear = 2 * f_0 * g_0 + f_0 * g_1 + f_1 * g_0 + 2 * f_1 * g_1
        return x_c / 6 * linear + (p.l_s - x_c) * f_1 * g_1

    a, b = k_e * bearing, k_e * (bearing + stretch)
    q_0, q_1 = k_e * coupling, k_e * (coupling + twist)
    p_0, p_1 = 1 - q_0, 1 - q_1
    m_e = p.rho_s * area * energy(a, b, a, b)
    J_1 = p.rho_s * polar * energy(p_0, p_1, p_0, p_1)
    J_2 = p.rho_s * polar * energy(q_0, q_1, q_0, q_1)
    J_12 = p.rho_s * polar * energy(p_0, p_1, q_0, q_1)
    m_11 = (J_1 + p.J_m) / r_2 + m_e
    m_12 = J_12 / r_2 - m_e
    m_22 = J_2 / r_2 + m_e + p.m_tab + m_wor

    # 1/k_e with loss: joints/(1 + jη) + the rest = (real - j imaginary)
    loss = joints / (1 + p.eta * p.eta)
    real, imaginary = loss + stretch + twist, p.eta * loss
    k_hat = real / (real * real + imaginary * imaginary)
    reduced = (m_11 * m_22 - m_12 * m_12) / (m_11 + 2 * m_12 + m_22)
    c_hys = imaginary / real * np.sqrt(k_hat * reduced)
    return Matrices(m_11, m_12, m_22, k_hat, c_hys)
