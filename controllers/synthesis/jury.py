"""Jury's test: are all roots of a polynomial inside the unit circle?

Exact for any polynomial with real coefficients; no root is computed.
Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1990, p. 35.
"""

import numpy as np

from fmus.model import FloatArray


def is_stable(polynomial: FloatArray) -> bool:
    """Tell whether all roots lie strictly inside the unit circle.

    Args:
        polynomial: coefficients, highest power first, shape (n + 1,).

    Raises:
        ValueError: the leading coefficient is zero.
    """
    a = np.array(polynomial, dtype=float)
    if a.size == 0 or a[0] == 0:
        raise ValueError("the leading coefficient is zero")
    while a.size > 1:
        if not abs(a[-1]) < abs(a[0]):
            return False
        # one row of the table: the polynomial of one degree less
        a = (a - a[-1] / a[0] * a[::-1])[:-1]
    return True
