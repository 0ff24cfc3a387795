"""When everybody is due, in exact rational time.

An instant is an integer count of one tick, the greatest common divisor of all
periods, offsets and the stop.  A clock n is due at first + i * every, i >= 0.
The instants are those of the closed interval [0, stop] at which a clock is due,
and 0 and stop in any case.  Times become floats in one place, ``seconds``.

Instants come in stretches.  The pattern of due clocks is stored for one
hyperperiod up to ``STORED`` entries and repeated, else all come from a heap;
both give the same instants.
"""

from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from heapq import heapify, heapreplace
from itertools import islice
from math import gcd, lcm
from typing import Generic, TypeVar

from orchestrator.errors import ScheduleError

STORED = 1_000_000
LAZY = 4096  # instants in a stretch that does not repeat

T = TypeVar("T")


@dataclass(frozen=True)
class Clock:
    """Due at offset + i * period (s), i = 0, 1, ..."""

    period: Fraction
    offset: Fraction = Fraction(0)


@dataclass(frozen=True)
class Stretch(Generic[T]):
    """The instants first + r * length + offsets[i], for each r < repeats all i.

    ``entries[i]`` says what happens at them.
    """

    first: int
    length: int
    repeats: int
    offsets: tuple[int, ...]
    entries: tuple[T, ...]

    def before(self, k: int) -> int:
        """Count the instants of all repetitions that lie before instant k."""
        if k <= self.first:
            return 0
        r, rest = 0, k - self.first
        if self.repeats > 1:
            r, rest = divmod(rest, self.length)
        whole = min(max(r, 0), self.repeats) * len(self.offsets)
        return whole + (bisect_left(self.offsets, rest) if r < self.repeats else 0)

    def __iter__(self) -> Iterator[tuple[int, T]]:
        """Yield every instant and its entry."""
        for r in range(self.repeats):
            begin = self.first + r * self.length
            for offset, entry in zip(self.offsets, self.entries, strict=True):
                yield begin + offset, entry


@dataclass(frozen=True)
class Schedule:
    """The instants of a run; ``every`` and ``first`` count ticks, per clock.

    A set of due clocks is a bit mask, bit i for the i-th clock of ``names``.
    """

    tick: Fraction
    stop: int
    names: tuple[str, ...]
    every: tuple[int, ...]
    first: tuple[int, ...]

    @classmethod
    def of(cls, clocks: Mapping[str, Clock], stop: Fraction) -> "Schedule":
        """Find the common tick of some clocks and the stop.

        Raises:
            ScheduleError: a period is not positive, an offset or the stop is
                negative, or the stop is too many ticks away to count exactly.
        """
        if stop < 0:
            raise ScheduleError(f"stop = {stop} s: a run ends at 0 or later")
        for name, clock in clocks.items():
            if clock.period <= 0:
                raise ScheduleError(f"{name}: period {clock.period} s is not positive")
            if clock.offset < 0:
                raise ScheduleError(f"{name}: offset {clock.offset} s is negative")
        times = [c.period for c in clocks.values()]
        times += [t for t in (*(c.offset for c in clocks.values()), stop) if t > 0]
        tick = rational_gcd(*times) if times else Fraction(1)
        count = int(stop / tick)
        if count * tick.numerator >= 2**53 or tick.denominator >= 2**53:
            raise ScheduleError(
                f"stop = {stop} s is {count} ticks of {tick} s: more than a float can "
                f"count exactly; choose periods with a larger common divisor"
            )
        return cls(
            tick,
            count,
            tuple(clocks),
            tuple(int(c.period / tick) for c in clocks.values()),
            tuple(int(c.offset / tick) for c in clocks.values()),
        )

    @property
    def hyperperiod(self) -> int:
        """Ticks after which the pattern repeats of the clocks due more than once."""
        return lcm(*(every for every in self.every if every <= self.stop))

    def seconds(self, k: int) -> float:
        """Return the time of instant k, rounded once: k * num / den in doubles."""
        return float(k * self.tick.numerator) / float(self.tick.denominator)

    def duration(self, ticks: int) -> float:
        """Return the float nearest to a number of ticks, in seconds."""
        return float(ticks * self.tick)

    def is_stored(self) -> bool:
        """Tell whether one hyperperiod is short enough to be kept in memory."""
        due = sum(self.hyperperiod // every for every in self.every)
        return 0 < due <= STORED and self._settled + self.hyperperiod < self.stop

    @property
    def _settled(self) -> int:
        """Instant from which on everything repeats, also when each was due last."""
        return max(self.first, default=0) + self.hyperperiod

    def instants(self) -> Iterator[tuple[int, int]]:
        """Yield every instant and the mask of the clocks due at it."""
        for stretch in self.stretches():
            yield from stretch

    def stretches(self) -> Iterator[Stretch[int]]:
        """Yield the instants and masks of ``instants`` as stretches, in order."""
        if not self.is_stored():
            yield from self._lazy(0, self.stop)
            return
        begin, length = self._settled, self.hyperperiod
        repeats = (self.stop - begin) // length
        yield from self._lazy(0, begin - 1)
        pattern = tuple(self.merged(begin, begin + length - 1))
        offsets = tuple(k - begin for k, _ in pattern)
        masks = tuple(mask for _, mask in pattern)
        yield Stretch(begin, length, repeats, offsets, masks)
        yield from self._lazy(begin + repeats * length, self.stop)

    def _lazy(self, begin: int, end: int) -> Iterator[Stretch[int]]:
        instants = self.merged(begin, end)
        while some := tuple(islice(instants, LAZY)):
            offsets, masks = tuple(k for k, _ in some), tuple(mask for _, mask in some)
            yield Stretch(0, 0, 1, offsets, masks)

    def merged(self, begin: int, end: int) -> Iterator[tuple[int, int]]:
        """Yield the instants of [begin, end] from a heap of next due times."""
        heap = [
            (first + -(-max(begin - first, 0) // every) * every, i)
            for i, (every, first) in enumerate(zip(self.every, self.first, strict=True))
        ]
        heapify(heap)
        k = begin
        while True:
            mask = 0
            while heap and heap[0][0] == k:
                _, i = heap[0]
                mask |= 1 << i
                heapreplace(heap, (k + self.every[i], i))
            if mask or k in (0, self.stop):
                yield k, mask
            if k >= end:
                return
            k = min(heap[0][0], end) if heap else end

    def ticks(self, name: str) -> int:
        """Count how often a clock is due in [0, stop]."""
        i = self.names.index(name)
        return max(0, (self.stop - self.first[i]) // self.every[i] + 1)


def rational_gcd(*values: Fraction) -> Fraction:
    """Largest rational dividing every value a whole number of times."""
    return Fraction(
        reduce(gcd, (v.numerator for v in values)),
        reduce(lcm, (v.denominator for v in values)),
    )
