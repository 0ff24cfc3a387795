"""Recorded rows on the ticks of a run, exactly.

A time is the shortest decimal that reads as its double, hence the text of a CSV cell
of up to 15 digits; or, with ``rate``, row k is at k times that period.  A tick is a
fraction.  Both are compared as integers.  Between two rows the value is the double
nearest to the straight line through them, or that of the row before.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import SECONDS
from orchestrator.signals.columns import Columns

Interpolation: TypeAlias = Literal["hold", "linear"]
Integers: TypeAlias = NDArray[Any]  # int64 where it fits, else Python's

DIGITS = 15
EXACT = 2.0**53
ROOM = 2**62
SHARE = 0.01  # of a period that a time may be beside its row


@dataclass(frozen=True)
class Rows:
    """Increasing times of rows: ``numbers`` of ``unit`` seconds."""

    numbers: Integers
    unit: Fraction

    def time(self, row: int) -> Fraction:
        return int(self.numbers[row]) * self.unit

    @property
    def period(self) -> Fraction | None:
        """Return how far apart the rows are, None if not all as far."""
        if len(self.numbers) < 2:
            return None
        steps = np.diff(self.numbers)
        return int(steps[0]) * self.unit if (steps == steps[0]).all() else None


def rows_of(columns: Columns, rate: Fraction | None = None) -> Rows:
    """Return the times of a file's rows; with ``rate`` (a period, s) row k is at k.

    Raises:
        ScenarioError: there are no times, they do not increase, have too many digits,
            or are not at ``rate``.
    """
    file, time = columns.file, columns.time
    if time is None:
        if rate is None:
            raise ScenarioError(
                f"{file}: has no column t or time; say how far apart its rows are, "
                f'e.g. rate = "10 kHz"'
            )
        return Rows(np.arange(columns.rows), rate)
    unit = SECONDS[columns.time_unit]
    if rate is not None:
        return _at_rate(columns, time, unit, rate)
    found = _decimal(time)
    if found is None:
        step = float(unit) * (time[-1] - time[0]) / max(1, len(time) - 1)
        raise ScenarioError(
            f"{file}: its times have more than {DIGITS} digits, so that nobody knows "
            f"which instants are meant; if the rows are evenly spaced say so with "
            f'rate = "..." (about {1 / step:.6g} Hz), or write fewer digits'
        )
    numbers, digits = found
    if len(back := np.flatnonzero(np.diff(numbers) <= 0)):
        raise ScenarioError(
            f"{file}: time does not increase from row {back[0] + 1} to {back[0] + 2}: "
            f"{time[back[0]]:.9g}, {time[back[0] + 1]:.9g} {columns.time_unit}"
        )
    return Rows(numbers, unit / 10**digits)


def _at_rate(
    columns: Columns, time: NDArray[np.float64], unit: Fraction, rate: Fraction
) -> Rows:
    first = int(np.floor(time[0] * float(unit / rate) + 0.5))
    numbers = first + np.arange(len(time))
    beside = np.abs(time * float(unit / rate) - numbers)
    if (beside > SHARE).any():
        row = int(np.argmax(beside > SHARE))
        raise ScenarioError(
            f"{columns.file}: row {row + 1} is at {time[row]:.9g} {columns.time_unit}, "
            f"not at {int(numbers[row])} times {rate} s as rate says"
        )
    return Rows(numbers, rate)


def _decimal(time: NDArray[np.float64]) -> tuple[Integers, int] | None:
    """Return integers n and digits d with time == n / 10^d, the smallest d."""
    for digits in range(DIGITS + 1):
        numbers = np.floor(time * 10.0**digits + 0.5)
        if np.max(np.abs(numbers)) >= EXACT:
            return None
        if np.array_equal(numbers / 10.0**digits, time):
            return numbers.astype(np.int64), digits
    return None


@dataclass(frozen=True)
class Ticks:
    """For every tick of a run: the row before or at it, and what is left to the tick.

    ``after[k]`` of ``between[k]`` (both integers) is the way from ``row[k]`` to the
    next row; 0 at a row, and after the last one.
    """

    row: NDArray[np.int64]
    after: Integers
    between: Integers


def ticks(rows: Rows, period: Fraction, begin: Fraction, count: int) -> Ticks:
    """Place ticks k * period, k < count, among rows of which ``begin`` (s) is t = 0."""
    scale = lcm(rows.unit.denominator, period.denominator, begin.denominator)
    row_unit, step, origin = (int(x * scale) for x in (rows.unit, period, begin))
    ends = max(abs(int(n)) for n in (rows.numbers[0], rows.numbers[-1]))
    largest = max(ends * row_unit, abs(origin) + count * step)
    kind = np.int64 if largest < ROOM else object
    at = rows.numbers.astype(kind) * row_unit
    when = origin + np.arange(count).astype(kind) * step
    row = np.maximum(np.searchsorted(at, when, side="right") - 1, 0).astype(np.int64)
    following = np.minimum(row + 1, len(at) - 1)
    after = np.where(following == row, 0, when - at[row])
    return Ticks(row, np.maximum(after, 0), at[following] - at[row])


def values_at(
    values: NDArray[np.float64], found: Ticks, interpolation: Interpolation
) -> NDArray[np.float64]:
    """Return a column's value at every tick."""
    result = values[found.row]
    if interpolation == "hold":
        return result
    following = values[np.minimum(found.row + 1, len(values) - 1)]
    (places,) = np.nonzero((found.after != 0) & (following != result))
    pairs = zip(
        *(x[places].tolist() for x in (result, following, found.after, found.between)),
        strict=True,
    )
    result[places] = [_between(*pair) for pair in pairs]
    return result


def _between(a: float, b: float, part: int, whole: int) -> float:
    """Return the double nearest to a + (b - a) part / whole."""
    (p, q), (r, s) = a.as_integer_ratio(), b.as_integer_ratio()
    return (p * s * (whole - part) + r * q * part) / (q * s * whole)
