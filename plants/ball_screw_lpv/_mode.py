"""The drive's flexible mode as identified, a function of nut position and mass.

    G = r_g²/(s (J_e s + B_e)) [1 1; 1 1] + (α + β s)/(s² + 2ζω s + ω²)

    Table 3.3:  o(x_c) = c_0 + c_1 x_c + c_2 x_c² + c_3 sin(x_c/r_g + c_4)
    Table 3.4:  o(x_c, m_wor) = c_0 + c_1 m_wor + c_2 (0.64 m - x_c)

Inputs are motor force f_m and external force f_c, outputs u_m and u_c, all along
the table's travel.  α_22, β_22 complete a mode of rank one (eq. 3.26).

Source: Hanifzadegan 2014, eq. 3.20 to 3.27, Tables 3.2 to 3.4.  Corrected there:
ω of Table 3.4 falls by 320, not 0.32 rad/s per metre; α_11 falls with 0.64 - x_c;
the last row is β_11, whose printed mass term is its constant
(docs/studies/ball_screw_lpv.md).
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import FloatArray, Var

R_G = 0.020 / (2 * np.pi)  # table travel per screw angle (m/rad), printed as 0.0032
_C3 = "coefficients c_0 ... c_3 over x_c (Table 3.3)"
_C4 = "constant, per kg, per metre of 0.64 - x_c (Table 3.4)"


class Mode(NamedTuple):
    """Damping ratio, frequency (rad/s), α (1/kg) and β (s/kg) at one point."""

    zeta: Any
    omega: Any
    alpha_11: Any
    alpha_12: Any
    beta_11: Any
    beta_12: Any


class Rigid(NamedTuple):
    """Rigid body (Table 3.2)."""

    J_e: Annotated[float, Var("kg.m2", "inertia at the motor", min=1e-9)] = 7.1432e-4
    B_e: Annotated[float, Var("N.m.s/rad", "viscous damping", min=0)] = 0.0156
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = R_G


class OverPosition(NamedTuple):
    """Coefficients of Table 3.3."""

    zeta: Annotated[FloatArray, Var("1", f"damping ratio: {_C3}")] = 1e-2 * np.array(
        [2.70, -2.36, 3.05, -0.15]
    )
    omega: Annotated[FloatArray, Var("1", f"frequency in rad/s: {_C3}")] = np.array(
        [1570.0, -490.0, 170.0, 0.0]
    )
    alpha_11: Annotated[FloatArray, Var("1", f"in 1/kg: {_C3}")] = 1e-3 * np.array(
        [5.05, 7.05, -3.83, -0.22]
    )
    alpha_12: Annotated[FloatArray, Var("1", f"in 1/kg: {_C3}")] = 1e-3 * np.array(
        [-11.3, -5.2, 2.90, -0.4]
    )
    beta_11: Annotated[FloatArray, Var("1", f"in s/kg: {_C3}")] = 1e-6 * np.array(
        [-0.99, -2.52, 2.60, 0.396]
    )
    beta_12: Annotated[FloatArray, Var("1", f"in s/kg: {_C3}")] = 1e-6 * np.array(
        [2.77, 1.98, -2.28, -0.71]
    )
    phase: Annotated[FloatArray, Var("rad", "c_4 of the rows in their order")] = (
        np.array([-1.90, -0.90, -2.90, -6.19, 1.90, -1.90])
    )


class OverPositionAndMass(NamedTuple):
    """Coefficients of Table 3.4."""

    zeta: Annotated[FloatArray, Var("1", f"damping ratio: {_C4}")] = np.array(
        [0.023, 0.0, 0.0]
    )
    omega: Annotated[FloatArray, Var("1", f"frequency in rad/s: {_C4}")] = np.array(
        [1299.0, -15.0, 320.0]
    )
    alpha_11: Annotated[FloatArray, Var("1", f"in 1/kg: {_C4}")] = 1e-3 * np.array(
        [9.17, -0.11, -3.9]
    )
    alpha_12: Annotated[FloatArray, Var("1", f"in 1/kg: {_C4}")] = 1e-3 * np.array(
        [-15.35, 0.41, 2.8]
    )
    beta_11: Annotated[FloatArray, Var("1", f"in s/kg: {_C4}")] = 1e-6 * np.array(
        [-2.825, 0.0, 0.82]
    )
    beta_12: Annotated[FloatArray, Var("1", f"in s/kg: {_C4}")] = 1e-6 * np.array(
        [5.15, -0.08, -0.48]
    )


def over_position(x_c: Any, c: OverPosition, r_g: Any, run_out: Any = 0.0) -> Mode:
    """Return the mode at nut position x_c (m); ``run_out`` (0 or 1) adds the sine."""

    def at(row: int) -> Any:
        o = c[row]
        smooth = o[0] + x_c * (o[1] + x_c * o[2])
        return smooth + run_out * o[3] * np.sin(x_c / r_g + c.phase[row])

    return Mode(*(at(row) for row in range(6)))


def over_position_and_mass(x_c: Any, m_wor: Any, c: OverPositionAndMass) -> Mode:
    """Return the mode at nut position x_c (m) with workpiece mass m_wor (kg)."""
    return Mode(*(o[0] + o[1] * m_wor + o[2] * (0.64 - x_c) for o in c))


def inertia(m_wor: Any, rigid: Rigid) -> Any:
    """Return J_e (kg m²) with a workpiece of mass m_wor (kg) (eq. 3.4)."""
    return rigid.J_e + rigid.r_g * rigid.r_g * m_wor


def force_on_table(mode: Mode) -> tuple[Any, Any]:
    """Return b_0, b_1 by which f_c drives q and q̇; f_m does so by 0 and 1.

    With C = [α_11 β_11; α_12 β_12] on (q, q̇) they give G_12 = G_21 exactly, and
    with it the rank-one completion (3.26) to 0.03 %.
    """
    damping, stiffness = 2 * mode.zeta * mode.omega, mode.omega * mode.omega
    first = damping * mode.alpha_11 - stiffness * mode.beta_11
    determinant = first * mode.beta_11 - mode.alpha_11 * mode.alpha_11
    b_0 = mode.alpha_12 * mode.beta_11 - mode.alpha_11 * mode.beta_12
    b_1 = first * mode.beta_12 - mode.alpha_11 * mode.alpha_12
    return b_0 / determinant, b_1 / determinant
