"""Continuous forms of the gantry's controllers, as responses at complex s.

    x     C(s) h_x(s)                                        eq. 4.18
    mimo  h(s) diag(α) {D(s) (1, 1)ᵀ(α_1, α_2) + β s [1, -1; -1, 1] + k_i/s I}
    pid   h_p(s) diag(α) (K_p + K_i/s + K_d s)

All act on the errors; ``s`` has shape (n,), matrices (n, 2, 2).
Source: Gordon 2010, sec. 4.4.1, eq. 4.25 to 4.30.
"""

import numpy as np
from numpy.typing import NDArray

from controllers.gantry import filters as gantry_filters
from controllers.gantry import mimo as gantry_mimo
from controllers.gantry import pid as gantry_pid
from controllers.gantry import schedule as gantry_schedule
from controllers.gantry import x as gantry_x
from controllers.gantry import x_filters as gantry_x_filters
from controllers.gantry._common import schedule
from controllers.synthesis.frequency import ComplexArray
from controllers.synthesis.loop_shaping import lead_ratio


def notch(
    s: ComplexArray, omega_hz: float, zeta_N: float, zeta_D: float
) -> ComplexArray:
    """Return (s² + 2ζ_N ω s + ω²) / (s² + 2ζ_D ω s + ω²)."""
    w = 2 * np.pi * omega_hz
    square = s * s + w * w
    return np.asarray((square + 2 * zeta_N * w * s) / (square + 2 * zeta_D * w * s))


def x_filters(p: gantry_x_filters.Parameters, s: ComplexArray) -> ComplexArray:
    """Return the filter pack of the x axis."""
    low_pass = 1 / (1 + s / (2 * np.pi * p.omega_lpf_hz))
    return np.asarray(
        notch(s, p.omega_N1_hz, p.zeta_N1, p.zeta_D1)
        * notch(s, p.omega_N2_hz, p.zeta_N2, p.zeta_D2)
        * notch(s, p.omega_N3_hz, p.zeta_N3, p.zeta_D3)
        * low_pass
    )


def x_law(p: gantry_x.Parameters, s: ComplexArray) -> ComplexArray:
    """Return the whole feedback of the x axis, error to control signal."""
    lead = (p.T_d * s + 1) / (s / p.a + 1)
    return np.asarray(p.K * (p.T_i * s + 1) / s * lead**2 * x_filters(p.filters, s))


def y_filters(p: gantry_filters.Parameters, s: ComplexArray) -> ComplexArray:
    """Return h(s), the filter pack of either gantry motor."""
    w = 2 * np.pi * p.omega_lpf_hz
    h = w * w / (s * s + 2 * p.zeta_lpf * w * s + w * w)
    h = h * notch(s, p.omega_N1_hz, p.zeta_N1, p.zeta_D1)
    h = h * notch(s, p.omega_N2_hz, p.zeta_N2, p.zeta_D2)
    h = h * notch(s, p.omega_N3_hz, p.zeta_N3, p.zeta_D3)
    h = h * notch(s, p.omega_N4_hz, p.zeta_N4, p.zeta_D4)
    if p.lead_on:
        gamma, w = lead_ratio(p.phi_lead), 2 * np.pi * p.omega_lead_hz
        h = h * (gamma * s / w + 1) / (s / (gamma * w) + 1)
    return np.asarray(h)


def mimo_law(p: gantry_mimo.Parameters, x: float, s: ComplexArray) -> ComplexArray:
    """Return K(s) of eq. 4.30 with the table at x (m), shape (n, 2, 2)."""
    alpha = distribution(p, x)
    D = p.K * (p.T_d * s + 1) / (s / p.a + 1)
    twist = np.array([[1.0, -1.0], [-1.0, 1.0]])
    averaged = np.outer(np.ones(2), alpha)
    braces = (
        D[:, None, None] * averaged
        + p.beta * s[:, None, None] * twist
        + (p.k_i / s)[:, None, None] * np.eye(2)
    )
    h = y_filters(p.filters, s)
    return np.asarray(h[:, None, None] * np.diag(alpha) @ braces)


def pid_law(p: gantry_pid.Parameters, x: float, s: ComplexArray) -> ComplexArray:
    """Return K(s) of the independent PID controllers, shape (n, 2, 2)."""
    pid = (p.K_p + p.K_i / s + p.K_d * s) * y_filters(p.filters, s)
    return np.asarray(pid[:, None, None] * np.diag(distribution(p, x)))


def distribution(
    p: gantry_mimo.Parameters | gantry_pid.Parameters, x: float
) -> NDArray[np.float64]:
    """Return (α_1, α_2) of a controller's own schedule at x (m)."""
    at = gantry_schedule.Input(x)
    _, now = gantry_schedule.step(gantry_schedule.State(), at, schedule(p), 0.0)
    return np.array([now.alpha_1, now.alpha_2])
