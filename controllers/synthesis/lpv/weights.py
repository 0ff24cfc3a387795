"""Weighting functions of H-infinity design.

Gains M are plain ratios of 1/W, not decibels: ``decibels(-140)`` converts.
"""

import numpy as np

from controllers.synthesis.lpv.systems import ComplexArray, Matrix, System, series


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


def rational(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> System:
    """Return a biproper quotient of polynomials, highest power first, as a cascade.

    Zeros and poles go into blocks of first and second order, which keeps states of
    one size where a companion form does not.

    Raises:
        ValueError: the degrees differ.
    """
    if len(numerator) != len(denominator):
        raise ValueError("numerator and denominator are of different degrees")
    top, bottom = (
        _factors(np.roots(c).astype(complex)) for c in (numerator, denominator)
    )
    if [len(f) for f in top] != [len(f) for f in bottom]:
        raise ValueError("real zeros and poles do not pair: give another weight")
    whole = System(
        np.zeros((0, 0)),
        np.zeros((0, 1)),
        np.zeros((1, 0)),
        np.array([[numerator[0] / denominator[0]]]),
    )
    for zeros, poles in zip(top, bottom, strict=True):
        whole = series(whole, _block(np.poly(zeros).real, np.poly(poles).real))
    return whole


def _factors(roots: ComplexArray) -> list[ComplexArray]:
    """Return real roots alone and conjugate pairs together, real ones first."""
    real = [np.array([r.real]) for r in roots if abs(r.imag) < 1e-9 * abs(r)]
    pairs = [np.array([r, r.conj()]) for r in roots if r.imag >= 1e-9 * abs(r)]
    return [*real, *pairs]


def _block(top: Matrix, bottom: Matrix) -> System:
    """Return a quotient of monic polynomials; states scaled by the slowest root."""
    n = len(bottom) - 1
    size = float(np.abs(bottom[-1]) ** (1 / n))
    A = np.diag(np.full(n - 1, size), 1)
    A[-1] = -bottom[:0:-1] / size ** np.arange(n - 1, -1, -1)
    B = np.zeros((n, 1))
    B[-1, 0] = 1.0
    C = (top - bottom)[:0:-1] / size ** np.arange(n - 1, -1, -1)
    return System(A, B, C[None, :], np.eye(1))
