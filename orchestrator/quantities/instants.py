"""Instants first + k period, k = 0, 1, ...: exact, so that two sets can be met.

A signal is *published* at the instants of its source; rows between them repeat
what was published last.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Instants:
    """Times in s: ``first``, then every ``period``."""

    period: Fraction
    first: Fraction = Fraction(0)

    def common(self, other: "Instants") -> "Instants | None":
        """Return the instants of both, None if there are none."""
        unit = lcm(*(f.denominator for i in (self, other) for f in (i.period, i.first)))
        p, q = int(self.period * unit), int(other.period * unit)
        a, b = int(self.first * unit), int(other.first * unit)
        both = gcd(p, q)
        if (b - a) % both:
            return None
        steps = (b - a) // both * pow(p // both, -1, q // both) % (q // both)
        whole, meeting = lcm(p, q), a + steps * p
        meeting += -(-max(0, max(a, b) - meeting) // whole) * whole
        return Instants(Fraction(whole, unit), Fraction(meeting, unit))

    def within(self, start: Fraction, end: Fraction) -> int:
        """Return how many there are from ``start`` to ``end``, both included."""
        past = -(-max(Fraction(0), start - self.first) // self.period)
        last = (end - self.first) // self.period
        return max(0, int(last - past) + 1)

    def among(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of the times (n,) of a run, in s, are of these instants."""
        k = np.rint((time - float(self.first)) / float(self.period)).astype(np.int64)
        unit = lcm(self.first.denominator, self.period.denominator)
        ticks = int(self.first * unit) + k * int(self.period * unit)
        found: NDArray[np.bool_] = (k >= 0) & (ticks / unit == time)
        return found

    def __str__(self) -> str:
        return f"{self.first} {self.period}"

    @classmethod
    def read(cls, text: str) -> "Instants":
        """Return the instants that ``str`` wrote."""
        first, period = map(Fraction, text.split())
        return cls(period, first)
