"""Weighting functions of H-infinity design.

Gains M are plain ratios of 1/W, not decibels: ``decibels(-140)`` converts.
"""

import numpy as np

from controllers.synthesis.lpv.systems import System, series


def decibels(value: float) -> float:
    """Return the ratio that is so many decibels."""
    return float(10 ** (value / 20))


def shelf(M_L: float, M_H: float, omega_b: float, k: int) -> System:
    """Return ((s/M_H^(1/k) + ω_b)/(s + ω_b M_L^(1/k)))^k, k ≥ 1.

    1/W is M_L at low and M_H at high frequency and crosses 1 near omega_b (rad/s)
    if M_L < 1 < M_H.  Source: Hanifzadegan 2014, eq. 4.13.
    """
    pole, high = omega_b * M_L ** (1 / k), M_H ** (-1 / k)
    one = _first_order(pole, omega_b - high * pole, high)
    whole = one
    for _ in range(k - 1):
        whole = series(whole, one)
    return whole


def corner(M_L: float, M_H: float, omega_b: float) -> System:
    """Return (s + ω_b)/(M_H (s + ω_b M_L/M_H)).

    1/W is M_L up to omega_b (rad/s), falls from there and ends at M_H < M_L: what
    Hanifzadegan 2014 draws (Fig. 4.6) where (4.13) has no crossing to speak of.
    """
    pole = omega_b * M_L / M_H
    return _first_order(pole, (omega_b - pole) / M_H, 1 / M_H)


def _first_order(pole: float, residue: float, high: float) -> System:
    return System(
        np.array([[-pole]]), np.eye(1), np.array([[residue]]), np.array([[high]])
    )
