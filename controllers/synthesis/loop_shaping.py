"""Loop shaping of one loop: integrator, leads and gain for a crossover and a margin.

    C(s) = K (T_i s + 1)/s ((T_d s + 1)/(s/a + 1))^n

    T_i = tan(90° + φ_PI)/ω_c
    φ   = -180° + PM - ∠P(jω_c) - φ_PI,  n leads of φ/n < 90° each
    γ   = √((1 + sin φ/n)/(1 - sin φ/n)),  T_d = γ/ω_c,  a = γ ω_c
    K   = 1/|C(jω_c) P(jω_c)|

P is plant with filters; the phase of its delay counts, its magnitude is 1.  Without
φ_PI there is no integrator: C = K lead^n.
Source: Gordon 2010, eq. 4.17, 4.18, 4.26.
"""

from typing import NamedTuple

import numpy as np


class Compensator(NamedTuple):
    """K, T_i (s; infinite without integrator), T_d (s), a (rad/s), γ and n leads.

    ``phi`` is the phase of each lead (rad).
    """

    K: float
    T_i: float
    T_d: float
    a: float
    gamma: float
    phi: float
    leads: int


def lead_ratio(phi: float) -> float:
    """Return γ of the lead with the largest phase phi (rad).

    Raises:
        ValueError: one lead cannot give that phase.
    """
    if not 0 <= phi < np.pi / 2:
        raise ValueError(
            f"a lead gives 0 to 90 degrees, not {np.rad2deg(phi):.4g}; take more leads"
        )
    return float(np.sqrt((1 + np.sin(phi)) / (1 - np.sin(phi))))


def integrator_time(omega_c: float, phi_PI: float) -> float:
    """Return T_i (s) of (T_i s + 1)/s with phase phi_PI (rad, -π/2 to 0) at omega_c."""
    return float(np.tan(np.pi / 2 + phi_PI) / omega_c)


def shape(
    P: complex,
    omega_c: float,
    PM: float,
    phi_PI: float | None = None,
    leads: int | None = None,
) -> Compensator:
    """Return the compensator that gives crossover omega_c with phase margin PM.

    Args:
        P: response of plant, filters and delay at omega_c.
        omega_c: crossover (rad/s).
        PM: phase margin (rad).
        phi_PI: phase of the integrator at omega_c (rad, negative), None without.
        leads: number of leads; the fewest that suffice if None.

    Raises:
        ValueError: that many leads cannot give the phase, or it needs none.
    """
    lag = 0.0 if phi_PI is None else phi_PI
    phase = np.mod(np.angle(P), -2 * np.pi)  # a drive lags: between -360° and 0
    needed = -np.pi + PM - phase - lag
    if leads is None:
        leads = max(1, int(np.floor(needed / (np.pi / 2))) + 1)
    phi = float(needed) / leads
    gamma = lead_ratio(phi)
    T_d, a = gamma / omega_c, gamma * omega_c
    s = 1j * omega_c
    C = ((T_d * s + 1) / (s / a + 1)) ** leads
    T_i = np.inf
    if phi_PI is not None:
        T_i = integrator_time(omega_c, phi_PI)
        C = C * (T_i * s + 1) / s
    return Compensator(float(1 / abs(C * P)), T_i, T_d, a, gamma, phi, leads)
