"""Identified axes of the machining centre, command (V) to position (m).

    G_i = p_t/(2π) k_t k_a/(J_e s² + B_e s) G_flex,i

The flexible factors are quotients of polynomials of degree five to eleven in s: their
roots come with s = 1000 p, in which the coefficients stay within twelve decades, and
each root is polished by Newton's rule.

The denominator of z is printed to two digits and, as it stands, unstable.  The one
below is Hurwitz and within half a unit of each printed digit; others are too, and
their modes beyond 400 rad/s differ.

Source: Hanifzadegan 2014, sec. 8.3, Tables 8.1 and 8.2.  B_e of z reads 0.008134 (a
page number runs into the printed one).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fmus.model import FloatArray

PER = 1000.0  # rad/s: unit in which polynomials are solved


class Axis(NamedTuple):
    """Gain (A/V), pitch (m), inertia (kg m²), damping (N m s/rad), flexible factor."""

    k_a: float
    p_t: float
    J_e: float
    B_e: float
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    k_t: float = 0.4769

    @property
    def gain(self) -> float:
        """Acceleration per command (m/(s² V)) of the rigid body."""
        return self.p_t / (2 * np.pi) * self.k_t * self.k_a / self.J_e

    @property
    def pole(self) -> float:
        """Pole of the rigid body besides the integrator (rad/s)."""
        return -self.B_e / self.J_e


X = Axis(
    6.4898,
    0.010,
    0.0071,
    0.0678,
    (-17.06, -3.041e4, 2.396e8, 6.038e11, 1.689e15, 2.155e18),
    (1.0, 463.5, 9.845e6, 3.014e9, 2.409e13, 3.699e15, 2.6e18),
)
Y = Axis(
    7.5768,
    0.010,
    0.00979,
    0.0287,
    (53.38, 472.6, 3.023e8, 1.346e11, 5.354e13),
    (1.0, 169.5, 4.263e6, 4.736e8, 4.927e11, 3.874e13),
)
Z = Axis(
    6.4841,
    0.008,
    0.021887,
    0.008134,
    (
        *(-114.5, -6.2e4, -9.4e8, -6.4e11, -2.1e15, -1.9e18, -4.6e19),
        *(-1.7e24, 2.3e27, -1.1e29, 4.3e32),
    ),
    (
        *(1.0, 584.926, 1.0176e7, 4.77323e9, 3.47326e13, 1.32677e16, 4.88049e19),
        *(1.47323e22, 2.52635e25, 5.42675e27, 2.40535e30, 3.57378e32),
    ),
)


class Modes(NamedTuple):
    """Partial fractions of a whole axis: poles (rad/s) and residues, (n,)."""

    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]


def modes(axis: Axis) -> Modes:
    """Return the partial fractions of an axis, integrator and rigid pole first."""
    top, bottom = _scaled(axis.numerator), _scaled(axis.denominator)
    flexible = polished(bottom)
    rigid = np.array([0.0, axis.pole / PER], dtype=complex)
    scaled = np.concatenate([rigid, flexible])
    numerator = np.polyval(top, scaled) * axis.gain / PER**2
    residues = []
    for i, pole in enumerate(scaled):
        others = np.delete(scaled, i)
        residues.append(numerator[i] / (bottom[0] * np.prod(pole - others)))
    found = np.array(residues, dtype=np.complex128)
    return Modes(np.asarray(scaled * PER, dtype=np.complex128), found * PER)


def polished(coefficients: FloatArray, steps: int = 3) -> NDArray[np.complex128]:
    """Return the roots of a polynomial, each after some steps of Newton's rule."""
    roots = np.roots(coefficients).astype(complex)
    slope = np.polyder(coefficients)
    for _ in range(steps):
        roots = roots - np.polyval(coefficients, roots) / np.polyval(slope, roots)
    return np.asarray(roots)


def _scaled(coefficients: tuple[float, ...]) -> FloatArray:
    """Return a polynomial in p = s/1000; its values are those at s over 1000^5."""
    powers = np.arange(len(coefficients))[::-1]
    return np.asarray(np.array(coefficients) * PER ** (powers - 5.0))
