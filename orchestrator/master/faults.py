"""Faults on connections: what an input receives instead of what was published.

A fault stands behind the copy of a connection, in the sink's own units, and acts
while start <= t < end: it is renewed when the source publishes and, exactly at
the times its window begins and ends, for what was published before.  A
continuous sink with variable steps has its step split there, any other takes the
value at its next step.  Initialisation sees no fault.

    stuck         the last value before the window
    bias, gain    value + b, value * g
    quantisation  q * floor(value / q + 1/2)
    override      a value instead
    delay         what was published n publications of the source earlier

Several faults of one input act one after the other.  Nothing is random.  This is
the reference; ``orchestrator/native/faults.h`` has the same laws for the other
executors, with the same bits.
"""

from collections import deque
from collections.abc import Callable
from fractions import Fraction
from math import ceil, floor
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.master.layout import Faulty, Wiring
from orchestrator.master.places import views
from orchestrator.master.remembered import Words, numbers, words
from orchestrator.master.schedule import Schedule
from orchestrator.system import Fault, FaultKind

Law: TypeAlias = Callable[[float, float], float]

_LAWS: dict[FaultKind, Law] = {
    "bias": lambda v, b: v + b,
    "gain": lambda v, g: g * v,
    "quantisation": lambda v, q: q * floor(v / q + 0.5),
    "override": lambda _v, given: given,
}


class Faults:
    """All faults of a run; ``vector`` is that after initialisation."""

    def __init__(
        self, wiring: Wiring, schedule: Schedule, vector: NDArray[np.float64]
    ) -> None:
        seen = views(vector)
        self._inputs = [
            _Input(f, schedule, seen[f.dtype], float if f.dtype == "float64" else int)
            for f in wiring.faulty
        ]
        self._of: dict[str, list[_Input]] = {}
        for faulty, place in zip(wiring.faulty, self._inputs, strict=True):
            self._of.setdefault(faulty.edge.source, []).append(place)

    def apply(self, source: str, k: int) -> None:
        """Renew what ``source`` just copied (without one: everything) at instant k."""
        for place in self._of[source] if source else self._inputs:
            place.renew(k, published=bool(source))

    def remembered(self) -> Words:
        """Return what all faulty numbers remember, one after the other."""
        return np.concatenate([words([], "int64"), *(p.held() for p in self._inputs)])

    def remember(self, known: Words) -> None:
        """Take over what was remembered in a run of the same system."""
        for place in self._inputs:
            known = place.take(known)


class _Input:
    """One number that has faults: ``clean`` is what it would receive."""

    def __init__(
        self, faulty: Faulty, schedule: Schedule, view: Any, number: type[float]
    ) -> None:
        self._view, self._place, self._number = view, faulty.place, number
        self._dtype = faulty.dtype
        self._there, self._back = faulty.affine, faulty.affine.inverse()
        self._clean: float = view[faulty.place]
        initial = self._ours(self._clean)
        self._chain = [_Acting(f, schedule, initial) for f in faulty.faults]

    def renew(self, k: int, *, published: bool) -> None:
        if published:
            self._clean = self._view[self._place]
        value = self._ours(self._clean)
        for fault in self._chain:
            value = fault(value, k, published)
        if not any(fault.acts(k) for fault in self._chain):
            value = self._clean  # not rounded there and back
        elif self._there.converts:
            value = self._there.gain * value + self._there.offset
        self._view[self._place] = self._number(value)

    def held(self) -> Words:
        chain = [value for fault in self._chain for value in fault.memory]
        return words([self._clean, *chain], self._dtype)

    def take(self, known: Words) -> Words:
        """Take over what this number remembers; return the rest."""
        sizes = [len(fault.memory) for fault in self._chain]
        whole = 1 + sum(sizes)
        self._clean, *rest = numbers(known[:whole], self._dtype)
        for fault, size in zip(self._chain, sizes, strict=True):
            fault.memory, rest = rest[:size], rest[size:]
        return known[whole:]

    def _ours(self, value: float) -> float:
        back = self._back
        return back.gain * value + back.offset if self._there.converts else value


class _Acting:
    """One fault with its memory: the last value, and those it holds back."""

    def __init__(self, fault: Fault, schedule: Schedule, initial: float) -> None:
        self._kind, self._value, tick = fault.kind, fault.value, schedule.tick
        self._start = ceil(fault.start / tick)
        self._end = None if fault.end is None else ceil(fault.end / tick)
        self._last = initial
        kept = fault.samples + 1
        self._line: deque[float] = deque([initial] * kept, maxlen=kept)

    @property
    def memory(self) -> list[float]:
        """What it remembers: its line if it is a delay, else the last value."""
        return list(self._line) if self._kind == "delay" else [self._last]

    @memory.setter
    def memory(self, known: list[float]) -> None:
        if self._kind == "delay":
            self._line.extend(known)
        else:
            (self._last,) = known

    def acts(self, k: int) -> bool:
        return k >= self._start and (self._end is None or k < self._end)

    def __call__(self, value: float, k: int, published: bool) -> float:
        acts = self.acts(k)
        if self._kind == "delay":
            if published:
                self._line.append(value)
            else:
                self._line[-1] = value
            return self._line[0] if acts else value
        if self._kind == "stuck":
            if not acts:
                self._last = value
            return self._last
        return _LAWS[self._kind](value, self._value) if acts else value


def describe(fault: Fault) -> str:
    """Return a fault in words, for lists: ``bias 0.5 from 0.1 s to 0.2 s``."""
    numbers = {
        "stuck": "",
        "delay": f" of {fault.samples} sample{'s' * (fault.samples > 1)}",
    }
    what = fault.kind + numbers.get(fault.kind, f" {fault.value:g}")
    begin, end = fault.start, fault.end
    if end is None:
        return f"{what} from {_seconds(begin)} on" if begin else f"{what} throughout"
    return f"{what} from {_seconds(begin)} to {_seconds(end)}"


def _seconds(time: Fraction) -> str:
    return f"{float(time):.9g} s"
