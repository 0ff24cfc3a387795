"""Modes of the drive by the wave equations of the screw, without the quasi-static step.

The screw carries longitudinal and torsional waves; it stands on the thrust bearing
k_b, hangs by the coupling k_c on the motor J_m, is free at its other end, and the nut
(twice k_n) takes force F and torque r_g F out of it for the table m:

    0 = Δ(ω) = 2/k_n + c_a(ω) + r_g² c_t(ω) - 1/(m ω²)

with the screw's compliances at the nut, c_a to a force and c_t to a torque.  At a root
the response of (u_m, u_c) has the residue φ φ', φ = (r_g² R, 1/(m ω²)) √(2ω/Δ'), where
R is the motor's angle under a unit torque at the nut.

Source: Hanifzadegan 2014, eq. A.1 to A.11.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from plants.ball_screw_lpv._screw import Screw

POSITIONS = tuple(np.linspace(0.1, 0.6, 11).round(3).tolist())  # m
MASSES = (0.0, 2.5, 5.0, 7.5, 10.0, 20.0, 50.0, 100.0)  # kg
HIGHEST = 9000.0  # rad/s


class WaveMode(NamedTuple):
    """Frequency (rad/s) and shape at motor and table, normalised (1/√kg)."""

    omega: float
    phi_m: float
    phi_c: float


def modes(x_c: float, m_wor: float = 0.0, p: Screw | None = None) -> list[WaveMode]:
    """Return the modes below 9000 rad/s at nut distance x_c (m), m_wor (kg)."""
    screw = Screw() if p is None else p
    table = screw.m_tab + m_wor

    def delta(omega: float) -> float:
        return _delta(omega, x_c, table, screw)[0]

    grid = np.linspace(200.0, HIGHEST, 4401)
    values = np.array([delta(omega) for omega in grid])
    found = []
    for k in np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0)):  # poles fall
        omega = float(brentq(delta, grid[k], grid[k + 1], xtol=1e-9))
        slope = (delta(omega + 1e-3) - delta(omega - 1e-3)) / 2e-3
        _, R = _delta(omega, x_c, table, screw)
        size = np.sqrt(2 * omega / slope)
        phi_m, phi_c = screw.r_g**2 * R * size, size / (table * omega**2)
        found.append(WaveMode(omega, float(phi_m), float(phi_c)))
    return found


def table() -> dict[str, object]:
    """Return the first two modes over position and mass, as the plant reads them.

    ``modes`` has shape (positions, masses, 6): ω, φ_m, φ_c of either.
    """
    rows = [[[*a, *b] for a, b in (modes(x, m)[:2] for m in MASSES)] for x in POSITIONS]
    return {
        "x_c": list(POSITIONS),
        "m_wor": list(MASSES),
        "modes": np.vectorize(lambda v: float(f"{v:.12g}"))(np.array(rows)).tolist(),
    }


def figures(x_c: float = 0.59, m_wor: float = 0.0) -> dict[str, float]:
    """Return the frequencies of the first two modes (rad/s)."""
    first, second = modes(x_c, m_wor)[:2]
    return {"first": first.omega, "second": second.omega}


def _delta(omega: float, x_c: float, m: float, p: Screw) -> tuple[float, float]:
    """Return Δ and the motor's angle under a unit torque at the nut."""
    area, polar = np.pi * p.d_s**2 / 4, np.pi * p.d_s**4 / 32
    motor = p.k_c - p.J_m * omega**2
    c_a, _ = _compliance(omega / np.sqrt(p.E_s / p.rho_s), p.E_s * area, p.k_b, x_c, p)
    at_end = -p.k_c * p.J_m * omega**2 / motor
    speed = np.sqrt(p.G_s / p.rho_s)
    c_t, end = _compliance(omega / speed, p.G_s * polar, at_end, x_c, p)
    value = 2 / p.k_n + c_a + p.r_g**2 * c_t - 1 / (m * omega**2)
    return value, p.k_c / motor * end


def _compliance(
    k: float, stiffness: float, at_end: float, x_c: float, p: Screw
) -> tuple[float, float]:
    """Return what a unit load at x_c moves there and at the end x = 0.

    k is the wave number (1/m), ``at_end`` what stands against the screw's end.
    """
    ratio = at_end / (stiffness * k)
    wave = np.cos(k * x_c) + ratio * np.sin(k * x_c)  # 1 at the end
    slope = k * (ratio * np.cos(k * x_c) - np.sin(k * x_c))
    beyond = k * np.tan(k * (p.l_s - x_c))
    here = 1 / (stiffness * (slope / wave - beyond))
    return float(here), float(here / wave)
