"""White Gaussian noise as a function of a seed and the number of the tick.

    (L, R) ← (R, (L + (R + seed + c_i)³) mod p),   i = 1 ... 10,
    from (L, R) = (⌊k/p⌋, k mod p),   p = 2²⁶ - 5
    n_1 = √(-2 ln u) cos 2πv,   n_2 = √(-2 ln u) sin 2πv,
    u = (L + 1/2)/p,   v = (R + 1/2)/p

No tick needs the one before it, and all of it is exact integers below 2⁵³ in doubles
until the logarithm: the same seed gives the same bits everywhere.  ``n_1`` and
``n_2`` are independent, of mean 0 and variance 1, and end at 6.1.
Source: M. Albrecht and others, ASIACRYPT 2016, sec. 2.1 (Feistel network of cubes in
a prime field, here with few rounds: for statistics, not for secrets); G. Box and
M. Muller, Annals of Mathematical Statistics 29 (1958) 610.
"""

from typing import Any

import numpy as np

P = 2.0**26 - 5  # a prime: the product of two residues is exact in a double
ROUNDS = 10
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
    radius = np.sqrt(-2 * np.log(u))
    return radius * np.cos(2 * np.pi * v), radius * np.sin(2 * np.pi * v)


def cube(a: Any) -> Any:
    """Return a³ mod p of a residue."""
    return modulo(a * modulo(a * a))


def modulo(a: Any) -> Any:
    """Return a mod p of a whole number from 0 to 2⁵², exactly."""
    rest = a - np.floor(a / P) * P
    rest = np.where(rest < 0, rest + P, rest)
    return np.where(rest >= P, rest - P, rest)
