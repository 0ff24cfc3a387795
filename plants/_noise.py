"""White Gaussian noise as a function of a seed and the number of the tick.

    (L, R) ← (R, (L + (R + seed + c_i)³) mod p),   i = 1 ... 10,
    from (L, R) = (⌊k/p⌋, k mod p),   p = 2²⁶ - 5
    n_1 = √(-2 ln u) cos 2πv,   n_2 = √(-2 ln u) sin 2πv,
    u = (L + 1/2)/p,   v = (R + 1/2)/p

No tick needs the one before it.  Until the logarithm all of it is exact integers below
2⁵³ in doubles; logarithm and turn are in plain operations of one order, so that the
same seed gives the same bits in NumPy, hence in a Python FMU, as in C.  ``n_1`` and
``n_2`` are independent, of mean 0 and variance 1, and end at 6.1.
Source: M. Albrecht and others, ASIACRYPT 2016, sec. 2.1 (Feistel network of cubes in
a prime field, here with few rounds: for statistics, not for secrets); G. Box and
M. Muller, Annals of Mathematical Statistics 29 (1958) 610.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

P = 2.0**26 - 5  # a prime: the product of two residues is exact in a double
ROUNDS = 10
LN_2 = 0.6931471805599453
FACTORIALS = np.cumprod([1.0, *range(1, 20)]).tolist()
COS = [(-1) ** i / FACTORIALS[2 * i] for i in range(10)]
SIN = [(-1) ** i / FACTORIALS[2 * i + 1] for i in range(10)]
# fractional parts of the golden ratio's multiples, spread over the residues
CONSTANTS = tuple(float(int((i * 0.6180339887498949 % 1) * P)) for i in range(1, 11))


def normals(k: Any, seed: Any) -> tuple[Any, Any]:
    """Return two independent standard normal numbers of tick k (whole, below 2⁵²)."""
    k = np.floor(k)
    high = np.floor(k / P)
    left, right = modulo(high), k - high * P
    key = np.floor(seed)
    for constant in CONSTANTS:
        left, right = right, modulo(left + cube(modulo(right + key + constant)))
    u, v = (left + 0.5) / P, (right + 0.5) / P
    radius = np.sqrt(-2 * logarithm(u))
    cos, sin = turn(v)
    return radius * cos, radius * sin


def logarithm(u: Any) -> Any:
    """Return ln u of 2⁻³¹ < u < 1: ln f - e ln 2, with u = f 2⁻ᵉ and f about 1.

    ln f = 2 (z + z³/3 + z⁵/5 ...), z = (f - 1)/(f + 1), z² below 0.03.
    """
    f, e = u, 0.0 * u
    for octaves in (16, 8, 4, 2, 1):
        small: Any = f < 2.0 ** (0.5 - octaves)
        e = np.where(small, e + octaves, e)
        f = np.where(small, f * 2.0**octaves, f)
    z = (f - 1) / (f + 1)
    return 2 * z * polynomial(z * z, [1 / (2 * i + 1) for i in range(12)]) - e * LN_2


def turn(v: Any) -> tuple[Any, Any]:
    """Return cos 2πv and sin 2πv of 0 < v < 1: series within an eighth of a turn."""
    quarters = np.floor(4 * v + 0.5)
    x = 2 * np.pi * (v - quarters / 4)
    cos = polynomial(x * x, COS)
    sin = x * polynomial(x * x, SIN)
    half = np.floor(quarters / 2)
    odd = quarters - 2 * half > 0
    sign = 1 - 2 * (half - 2 * np.floor(half / 2))
    return sign * np.where(odd, -sin, cos), sign * np.where(odd, cos, sin)


def polynomial(x: Any, coefficients: Sequence[float]) -> Any:
    """Return Σ c_i xⁱ by Horner's rule."""
    total: Any = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def cube(a: Any) -> Any:
    """Return a³ mod p of a residue."""
    return modulo(a * modulo(a * a))


def modulo(a: Any) -> Any:
    """Return a mod p of a whole number from 0 to 2⁵², exactly."""
    rest = a - np.floor(a / P) * P
    rest = np.where(rest < 0, rest + P, rest)
    return np.where(rest >= P, rest - P, rest)
