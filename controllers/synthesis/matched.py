"""Matched pole-zero discretisation of a transfer function.

    finite pole or zero  s₀ → exp(s₀ T_s)
    zero at infinity     s = ∞ → z = -1 (or left out, which costs a sample)
    gain                 G(z) / ((z - 1)/T_s)ⁿ → G(s) / sⁿ at z = 1, s = 0

with n the number of zeros less that of poles at s = 0.  Improper transfer
functions keep more zeros than poles; whoever runs them adds the delays.
Source: Gordon 2010, sections 3.2.3 and 3.3; the place of infinite zeros is ours.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from fmus.model import FloatArray


class Factored(NamedTuple):
    """A transfer function gain Π(s - zero) / Π(s - pole), or the same in z."""

    zeros: NDArray[np.complex128]
    poles: NDArray[np.complex128]
    gain: float


def factored(numerator: Sequence[float], denominator: Sequence[float]) -> Factored:
    """Factor polynomials in s, highest power first."""
    zeros, poles, gain = signal.tf2zpk(numerator, denominator)
    return Factored(zeros, poles, float(gain))


def matched(G: Factored, T_s: float, *, infinite_zeros: bool = True) -> Factored:
    """Discretise G(s) by matching poles and zeros.

    Args:
        G: transfer function in s (rad/s).
        T_s: sample time (s).
        infinite_zeros: put zeros at infinity to z = -1; else leave them out.

    Returns:
        The same in z, as many finite zeros as G has (and those at -1).
    """
    s_zeros = np.asarray(G.zeros, dtype=complex)
    s_poles = np.asarray(G.poles, dtype=complex)
    missing = max(0, len(s_poles) - len(s_zeros)) if infinite_zeros else 0
    zeros = np.concatenate([np.exp(s_zeros * T_s), np.full(missing, -1.0)])

    n = int(np.sum(s_zeros == 0) - np.sum(s_poles == 0))
    low_s = _product(-s_zeros) / _product(-s_poles)
    # 1 - exp(s₀ T_s) by expm1: slow poles would cancel
    low_z = _product(-np.expm1(s_zeros * T_s)) / _product(-np.expm1(s_poles * T_s))
    gain = G.gain * low_s / (low_z * 2.0**missing * T_s**n)
    return Factored(zeros, np.exp(s_poles * T_s), float(np.real(gain)))


def _product(factors: NDArray[np.complex128]) -> complex:
    """Multiply the factors that do not vanish."""
    return complex(np.prod(factors[factors != 0]))


def coefficients(G: Factored) -> tuple[FloatArray, FloatArray]:
    """Multiply the factors out, highest power first: numerator, monic denominator."""
    numerator, denominator = signal.zpk2tf(G.zeros, G.poles, G.gain)
    return np.real(numerator), np.real(denominator)
