"""The drive's models as matrices: (f_m, f_c) → (u_m, u_c), SI.

The same physics as ``plants.ball_screw_lpv``, frozen at one nut position and mass.
Source: Hanifzadegan 2014, eq. 3.28 to 3.35 in the minimal form of four states.
"""

import numpy as np

from controllers.synthesis.lpv.systems import System
from plants.ball_screw_lpv._mode import (
    R_G,
    Mode,
    OverPosition,
    OverPositionAndMass,
    Rigid,
    force_on_table,
    inertia,
    over_position,
    over_position_and_mass,
)
from plants.ball_screw_lpv._screw import Screw, matrices

VOLT = 0.72 * 0.887 / R_G  # motor force per command, k_t k_a/r_g (N/V)
MOTOR, TABLE = [0], [1]  # of inputs and outputs


def over_x(x_c: float, run_out: float = 0.0) -> System:
    """Return the plant of Table 3.3 at nut position x_c (m)."""
    mode = over_position(x_c, OverPosition(), R_G, run_out)
    return with_mode(mode, 0.0)


def over_x_and_mass(x_c: float, m_wor: float) -> System:
    """Return the plant of Table 3.4 at x_c (m) with workpiece m_wor (kg)."""
    return with_mode(over_position_and_mass(x_c, m_wor, OverPositionAndMass()), m_wor)


def with_mode(mode: Mode, m_wor: float, rigid: Rigid | None = None) -> System:
    """Return rigid body and flexible mode; states u_0, its rate, q, q̇."""
    rigid = Rigid() if rigid is None else rigid
    J_e, (b_0, b_1) = inertia(m_wor, rigid), force_on_table(mode)
    push = rigid.r_g**2 / J_e
    damping, stiffness = 2 * mode.zeta * mode.omega, mode.omega**2
    A = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -rigid.B_e / J_e, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, -stiffness, -damping],
        ]
    )
    B = np.array([[0.0, 0.0], [push, push], [0.0, b_0], [1.0, b_1]])
    C = np.array(
        [
            [1.0, 0.0, mode.alpha_11, mode.beta_11],
            [1.0, 0.0, mode.alpha_12, mode.beta_12],
        ]
    )
    return System(A, B, C, np.zeros((2, 2)))


def hybrid(x_c: float, m_wor: float, screw: Screw | None = None) -> System:
    """Return the analytic model (eq. 3.12); states u_m, u_c and their rates."""
    p = Screw() if screw is None else screw
    m = matrices(x_c, m_wor, p)
    M = np.array([[m.m_11, m.m_12], [m.m_12, m.m_22]])
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    C = np.diag([p.c_m / p.r_g**2, p.c_c]) + m.c_hys * spring
    zero, eye = np.zeros((2, 2)), np.eye(2)
    solved = np.linalg.solve(M, np.hstack([-m.k_e * spring, -C, eye]))
    A = np.block([[zero, eye], [solved[:, :2], solved[:, 2:4]]])
    B = np.vstack([zero, solved[:, 4:]])
    return System(A, B, np.hstack([eye, zero]), zero)


def rigid_body(m_wor: float = 0.0, rigid: Rigid | None = None) -> System:
    """Return the rigid body f_m → u_c alone (eq. 3.21)."""
    p = Rigid() if rigid is None else rigid
    J_e = inertia(m_wor, p)
    A = np.array([[0.0, 1.0], [0.0, -p.B_e / J_e]])
    B = np.array([[0.0], [p.r_g**2 / J_e]])
    return System(A, B, np.array([[1.0, 0.0]]), np.zeros((1, 1)))


def part(system: System, outputs: list[int], inputs: list[int]) -> System:
    """Return some outputs and inputs of a system."""
    A, B, C, D = system
    return System(A, B[:, inputs], C[outputs], D[np.ix_(outputs, inputs)])
