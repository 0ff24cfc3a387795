"""Continuous forms of the ball-screw controllers, from their run-time parameters.

    MC-PPC   u = -G_fp (K_v1 ẋ_1 + K_v2 ẋ_2 + K_x1 x_1 + K_x2 x_2 + K_i2 x_2/s)
    P-PI     u = -G_fp (K_pv + K_iv/s) (ẋ_1 + K_px x_2)

Inputs are (ẋ_1, ẋ_2, x_1, x_2): no derivative has to be approximated.
Source: Gordon 2010, equations 3.5 to 3.10 and 3.27.
"""

import control as ct
import numpy as np

from controllers.ball_screw import filter_pack, mc_ppc, p_pi


def mc_ppc_law(p: mc_ppc.Parameters) -> ct.StateSpace:
    """Return the state feedback with integrator and filter pack."""
    g = p.gains
    K = np.array([[g.K_v1, g.K_v2, g.K_x1, g.K_x2]])
    feedback = ct.ss(0, [[0, 0, 0, 1]], -g.K_i2, -K)
    return filters(p.filters) * feedback


def p_pi_law(p: p_pi.Parameters) -> ct.StateSpace:
    """Return the position and velocity loops with filter pack."""
    v_e = np.array([[-1, 0, 0, -p.K_px]])
    feedback = ct.ss(0, v_e, p.K_iv, p.K_pv * v_e)
    return filters(p.filters) * feedback


def filters(p: filter_pack.Parameters) -> ct.StateSpace:
    """Return G_fp, one section after the other."""
    w = 2 * np.pi * p.omega_lpf_hz
    return (
        ct.ss(-w, w, 1, 0)
        * _notch(p.omega_n2_hz, p.zeta_z2, p.zeta_p2)
        * _notch(p.omega_n1_hz, p.zeta_z1, p.zeta_p1)
    )


def _notch(f_hz: float, zeta_z: float, zeta_p: float) -> ct.StateSpace:
    w = 2 * np.pi * f_hz
    # states scaled by ω, so that the matrices stay of one size
    A = [[0, w], [-w, -2 * zeta_p * w]]
    return ct.ss(A, [[0], [w]], [[0, 2 * (zeta_z - zeta_p)]], 1)
