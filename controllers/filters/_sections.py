"""Pole-zero matched sections: every finite pole or zero s_0 becomes exp(s_0 T_s).

A pair s² + q_1 s + q_0 becomes z² - 2ρ cos(ωT) z + ρ², kept in differences,

    Q(z) = (z - 1)² + α (z - 1) + β,    α = 2 (1 - ρ cos ωT),
                                        β = (1 - ρ)² + 2ρ (1 - cos ωT)

since at high rates α and β are small and the sum of plain coefficients loses
their digits.  A low-pass has its zero at z = -1.  Gains match at zero frequency.
Source: Gordon 2010, sec. 3.2.3 (pole-zero matching), eq. 3.9, 3.10.
"""

from typing import Any, NamedTuple

import numpy as np


class Pair(NamedTuple):
    """Coefficients of a matched pair of poles or zeros in differences."""

    alpha: Any
    beta: Any


class Section(NamedTuple):
    """(b_0 + b_1 z⁻¹ + b_2 z⁻²) / (1 + a_1 z⁻¹ + a_2 z⁻²)."""

    b_0: Any
    b_1: Any
    b_2: Any
    a_1: Any
    a_2: Any


class First(NamedTuple):
    """(b_0 + b_1 z⁻¹) / (1 - p z⁻¹)."""

    b_0: Any
    b_1: Any
    p: Any


class LowPass(NamedTuple):
    """gain/2 (1 + z⁻¹) / (1 - p z⁻¹) with gain = 1 - p."""

    p: Any
    gain: Any


def decay(pole: Any, T_s: Any) -> tuple[Any, Any]:
    """Return exp(-pole T_s) and, in full precision, 1 - exp(-pole T_s).

    ``pole`` is positive for a stable pole at s = -pole (rad/s).
    """
    return np.exp(-pole * T_s), -np.expm1(-pole * T_s)


def pair(q_1: Any, q_0: Any, T_s: Any) -> Pair:
    """Match the roots of s² + q_1 s + q_0, complex or real."""
    sigma = q_1 / 2
    rho, missing = decay(sigma, T_s)
    square = q_0 - sigma * sigma
    half = np.sqrt(np.abs(square)) * (T_s / 2)
    # 1 - cos ωT for complex roots, 1 - cosh for real ones
    dip = np.where(square >= 0, 2 * np.sin(half) ** 2, -2 * np.sinh(half) ** 2)
    alpha = 2 * (missing + rho * dip)
    return Pair(alpha, missing * missing + 2 * rho * dip)


def notch(omega_hz: Any, zeta_z: Any, zeta_p: Any, T_s: Any) -> Section:
    """Match (s² + 2ζ_z ω s + ω²) / (s² + 2ζ_p ω s + ω²), ω = 2π omega_hz."""
    omega = 2 * np.pi * omega_hz
    zero = pair(2 * zeta_z * omega, omega * omega, T_s)
    pole = pair(2 * zeta_p * omega, omega * omega, T_s)
    gain = pole.beta / zero.beta
    return Section(
        b_0=gain,
        b_1=gain * (zero.alpha - 2),
        b_2=gain * (1 - zero.alpha + zero.beta),
        a_1=pole.alpha - 2,
        a_2=1 - pole.alpha + pole.beta,
    )


def low_pass(omega: Any, T_s: Any) -> LowPass:
    """Match ω / (s + ω), ω in rad/s."""
    return LowPass(*decay(omega, T_s))


def lead(zero: Any, pole: Any, T_s: Any) -> First:
    """Match (s/zero + 1) / (s/pole + 1), zero and pole in rad/s."""
    rho, missing = decay(zero, T_s)
    p, gain = decay(pole, T_s)
    return First(gain / missing, -rho * gain / missing, p)


def second_order_low_pass(omega: Any, zeta: Any, T_s: Any) -> Section:
    """Match ω² / (s² + 2ζω s + ω²), ω in rad/s, both zeros at z = -1."""
    pole = pair(2 * zeta * omega, omega * omega, T_s)
    b = pole.beta / 4
    return Section(b, 2 * b, b, pole.alpha - 2, 1 - pole.alpha + pole.beta)


def filtered(w_1: Any, w_2: Any, x: Any, s: Section) -> tuple[Any, Any, Any]:
    """Run one sample through a section (direct form II transposed).

    Returns the two memories of the next sample and the output.
    """
    y = s.b_0 * x + w_1
    return s.b_1 * x - s.a_1 * y + w_2, s.b_2 * x - s.a_2 * y, y


def smoothed(w: Any, x: Any, s: LowPass) -> tuple[Any, Any]:
    """Run one sample through a low-pass; returns its next memory and the output."""
    y = s.gain / 2 * x + w
    return s.gain / 2 * x + s.p * y, y


def led(w: Any, x: Any, s: First) -> tuple[Any, Any]:
    """Run one sample through a first-order section; returns memory and output."""
    y = s.b_0 * x + w
    return s.b_1 * x + s.p * y, y
