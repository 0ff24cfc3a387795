"""Polynomials by which one controller hands over to another.

α(0) = 0 and α(1) = 1 with m derivatives of either end zero takes degree 2m + 1; for
m = 2 that is 10 s³ - 15 s⁴ + 6 s⁵.  Degree 6 leaves one free number c, which adds
c s³(1 - s)³ and never lowers the largest slope, 15/8.  To be evaluated in s: expanded
in a physical parameter the coefficients reach 1e8 and cancel.

Source: Hanifzadegan 2014, eq. 6.11, 6.19 to 6.21, 6.36.
"""

import numpy as np

from controllers.synthesis.lpv.systems import Matrix


def coefficients(c: float = 0.0) -> Matrix:
    """Return the factors of 1, s, ..., s⁶."""
    return np.array([0.0, 0.0, 0.0, 10 + c, -15 - 3 * c, 6 + 3 * c, -c])


def share(s: float, c: float = 0.0) -> float:
    """Return α at s, held at 0 and 1 beyond the ends."""
    s = float(np.clip(s, 0.0, 1.0))
    return float(np.polynomial.polynomial.polyval(s, coefficients(c)))


def slope(s: float, c: float = 0.0) -> float:
    """Return dα/ds, zero beyond the ends."""
    if not 0.0 < s < 1.0:
        return 0.0
    rates = np.polynomial.polynomial.polyder(coefficients(c))
    return float(np.polynomial.polynomial.polyval(s, rates))
