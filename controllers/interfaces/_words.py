"""Words of a bus as numbers: bits, whole numbers of 32 bits that run over.

Everything is a double that holds a whole number, exactly.
"""

from typing import Any

import numpy as np

SPAN = 2.0**32


def bit(word: Any, n: int) -> Any:
    """Return bit n of a word, 0 or 1."""
    return np.floor(word / 2.0**n) - 2 * np.floor(word / 2.0 ** (n + 1))


def whole(value: Any) -> Any:
    """Return the nearest whole number, half a one upwards."""
    return np.floor(value + 0.5)


def wrapped(value: Any) -> Any:
    """Return a whole number as one of 32 bits with sign holds it."""
    return value - SPAN * np.floor((value + SPAN / 2) / SPAN)


def limited(value: Any, bits: int) -> Any:
    """Return a whole number, held at the ends of an integer with sign."""
    end = 2.0 ** (bits - 1)
    return np.minimum(np.maximum(whole(value), -end), end - 1)
