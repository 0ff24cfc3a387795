"""Twice the digits: a number as the unevaluated sum of two doubles.

Only +, - and * of doubles, rounded to nearest and never contracted to fused
operations, so the same digits come out in NumPy, in CasADi and in compiled C.
Relative error of a sum or product of numbers of one sign below 1e-30.
Source: T. J. Dekker, A Floating-Point Technique for Extending the Available
Precision, Numerische Mathematik 18 (1971) 224-242; D. E. Knuth, The Art of
Computer Programming 2, sec. 4.2.2 (two_sum).
"""

from typing import Any, NamedTuple

import numpy as np

from fmus.model import is_record

SPLITTER = 134217729.0  # 2²⁷ + 1


class Double2(NamedTuple):
    """hi + lo, hi the nearest double to the sum."""

    hi: Any
    lo: Any


def exactly(a: Any) -> Double2:
    """Return a double as a pair."""
    return Double2(a, 0.0)


def two_sum(a: Any, b: Any) -> Double2:
    """Return a + b without error."""
    hi = a + b
    b_part = hi - a
    return Double2(hi, (a - (hi - b_part)) + (b - b_part))


def _normalised(hi: Any, lo: Any) -> Double2:
    total = hi + lo
    return Double2(total, lo - (total - hi))


def _halves(a: Any) -> tuple[Any, Any]:
    scaled = SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high


def two_product(a: Any, b: Any) -> Double2:
    """Return a b without error."""
    hi = a * b
    a_1, a_2 = _halves(a)
    b_1, b_2 = _halves(b)
    return Double2(hi, ((a_1 * b_1 - hi) + a_1 * b_2 + a_2 * b_1) + a_2 * b_2)


def add(x: Double2, y: Double2) -> Double2:
    """Return x + y."""
    hi = two_sum(x.hi, y.hi)
    lo = two_sum(x.lo, y.lo)
    first = _normalised(hi.hi, hi.lo + lo.hi)
    return _normalised(first.hi, first.lo + lo.lo)


def negative(x: Double2) -> Double2:
    """Return -x."""
    return Double2(-x.hi, -x.lo)


def subtract(x: Double2, y: Double2) -> Double2:
    """Return x - y."""
    return add(x, negative(y))


def multiply(x: Double2, y: Double2) -> Double2:
    """Return x y."""
    product = two_product(x.hi, y.hi)
    return _normalised(product.hi, product.lo + (x.hi * y.lo + x.lo * y.hi))


def divide(x: Double2, b: Any) -> Double2:
    """Return x / b for a double b."""
    quotient = x.hi / b
    product = two_product(quotient, b)
    rest = ((x.hi - product.hi) - product.lo) + x.lo
    return _normalised(quotient, rest / b)


def choose(condition: Any, x: Any, y: Any) -> Any:
    """Return x where the condition holds, else y; numbers or records of them."""
    if not is_record(x):
        return np.where(condition, x, y)
    pairs = zip(x, y, strict=True)
    return type(x)(*(choose(condition, *pair) for pair in pairs))


def at_least(x: Double2, y: Double2) -> Any:
    """Tell x >= y."""
    return (x.hi - y.hi) + (x.lo - y.lo) >= 0
