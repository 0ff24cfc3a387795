"""Second-order sections by Tustin's rule, s = 2/T_s (z - 1)/(z + 1).

Source: Hanifzadegan 2014, sec. 4.5 (0.36 ms; the rule is not stated).
"""

from typing import Any, NamedTuple


class Section(NamedTuple):
    """(b_0 + b_1 z⁻¹ + b_2 z⁻²), as numerator or normalised denominator."""

    b_0: Any
    b_1: Any
    b_2: Any


def polynomial(c_2: Any, c_1: Any, c_0: Any, T_s: Any) -> Section:
    """Return (c_2 s² + c_1 s + c_0)(1 + z⁻¹)² in powers of z⁻¹."""
    w = 2 / T_s
    square, rate = c_2 * w * w, c_1 * w
    return Section(square + rate + c_0, 2 * (c_0 - square), square - rate + c_0)
