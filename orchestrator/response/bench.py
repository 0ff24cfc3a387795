"""A composition whose outputs are broken: injected into, and read before that.

Broken at an output means: what is injected is added for all inputs that it drives.
Runs go on past the scenario's stop for as many periods as are asked for; the same
run without injection is subtracted, in motion too.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError, SimulationError, did_you_mean
from orchestrator.fmu.ports import Port, ports
from orchestrator.master.loaded import Loaded
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.master.wiring import links_of
from orchestrator.scenario.compose import Composition
from orchestrator.system import Injection, System, split_name

FIRST = 4  # periods of the first run

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Break:
    """An output that is broken, one number: its sinks, and ours to theirs there."""

    name: str
    unit: str
    sinks: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Rates:
    """Periods (s): of the broken outputs, after which the loop repeats, of it all.

    ``slowest`` are the components of the loop with its longest period.
    """

    T: Fraction
    loop: Fraction
    whole: Fraction
    slowest: tuple[str, ...]

    @property
    def slow(self) -> int:
        """How many samples of the broken outputs the loop needs to repeat itself."""
        return int(self.loop / self.T)


class Bench:
    """Runs a composition with signals injected at its breaks."""

    def __init__(
        self, composition: Composition, names: Sequence[str], loaded: Loaded
    ) -> None:
        self.composition, self._loaded = composition, loaded
        self.breaks = tuple(b for name in names for b in _breaks(composition, name))
        self.rates = _rates(composition, names)
        owner = split_name(names[0])[0]
        self._offset = composition.system.components[owner].offset
        self._twin: dict[int, Real] = {}
        self.periods = FIRST  # as many as the last run needed

    def responses(self, values: Sequence[Real | None], periods: int) -> Real:
        """Return (breaks, periods * n) of what the breaks read more than unexcited.

        ``values`` (n,) are injected at each break, again and again; None nothing.
        """
        n = next(len(v) for v in values if v is not None)
        return self._run(values, n, periods) - self.twin(n, periods)

    def twin(self, n: int, periods: int) -> Real:
        """Return (breaks, periods * n) of what the breaks read with no injection."""
        rows = periods * n
        known = max(self._twin, default=0)
        if known < rows:
            self._twin = {rows: self._run([None] * len(self.breaks), n, periods)}
            known = rows
        return self._twin[known][:, :rows]

    def system(self, values: Sequence[Real | None], n: int, periods: int) -> System:
        """Return the composition with these injections, recorded at its breaks."""
        injections: dict[str, Injection] = {}
        for broken, given in zip(self.breaks, values, strict=True):
            if given is not None:
                for sink, gain in broken.sinks:
                    injections[sink] = Injection(tuple((gain * given).tolist()))
        return replace(
            self.composition.system,
            stop=self._offset + periods * n * self.rates.T,
            record={b.name: (self.rates.T,) for b in self.breaks},
            injections=injections,
        )

    def _run(self, values: Sequence[Real | None], n: int, periods: int) -> Real:
        system = self.system(values, n, periods)
        signals = frozenset(b.name for b in self.breaks)
        series = Series(plan(system), signals, self._loaded)
        try:
            found, ended = series.run({})
        except SimulationError as error:
            raise ResponseError(
                f"a run of {float(system.stop):g} s failed, so its loop may be "
                f"unstable: {error}"
            ) from error
        if ended is not None:
            raise ResponseError(f"a run was {ended}; a response needs all its periods")
        rows = [found[b.name].values[: periods * n] for b in self.breaks]
        return np.array(rows)


@contextmanager
def bench(composition: Composition, names: Sequence[str]) -> Iterator[Bench]:
    """Give a composition broken at these outputs, its FMUs kept loaded.

    Raises:
        ResponseError: a name is no output of a closed loop, or their periods differ.
    """
    loaded = Loaded()
    try:
        yield Bench(composition, names, loaded)
    finally:
        loaded.drop()


def _breaks(composition: Composition, name: str) -> Iterator[Break]:
    system = composition.system
    owner, variable = split_name(name)
    if owner not in system.components or not variable:
        known = sorted(set(system.connections.values()))
        raise ResponseError(
            f"break {name}: no such output; {did_you_mean(name, known)}"
        )
    links = links_of(system, composition.fmus)[0]
    for port in ports(system.components[owner], composition.fmus[owner], variable):
        if port.variable.causality != "output" or port.variable.dtype != "float64":
            raise ResponseError(f"break {name}: {port.full_name} is no real output")
        sinks = tuple(
            (sink.full_name, affine.gain / (source.to_ours.gain * sink.to_theirs.gain))
            for source, sink, affine in links
            if _same(source, port)
        )
        if not sinks:
            raise ResponseError(f"break {name}: {port.full_name} drives nothing")
        yield Break(port.full_name, str(port.unit or "1"), sinks)


def _same(one: Port, other: Port) -> bool:
    return (one.component, one.variable.name, one.element) == (
        other.component,
        other.variable.name,
        other.element,
    )


def _rates(composition: Composition, names: Sequence[str]) -> Rates:
    system = composition.system
    owners = list(dict.fromkeys(split_name(name)[0] for name in names))
    parts = system.components
    clocks = {(parts[o].period, parts[o].offset) for o in owners}
    if len(clocks) > 1:
        raise ResponseError(
            f"breaks {', '.join(names)}: their components have different periods or "
            f"offsets; break outputs of one clock together"
        )
    loop = _loop(system, owners[0])
    for owner in owners:
        if owner not in _loop(system, owner):
            raise ResponseError(
                f"break {owner}: no connection leads back to it, so there is no loop"
            )
        loop |= _loop(system, owner)
    slowest = max(parts[name].period for name in loop)
    return Rates(
        parts[owners[0]].period,
        _common([parts[name].period for name in loop]),
        _common([part.period for part in parts.values()]),
        tuple(sorted(name for name in loop if parts[name].period == slowest)),
    )


def _loop(system: System, owner: str) -> set[str]:
    """Return the components from which and to which connections lead from ``owner``."""
    after, before = _reached(system, owner, 1), _reached(system, owner, -1)
    return after & before


def _reached(system: System, owner: str, way: int) -> set[str]:
    edges = [
        (split_name(source)[0], split_name(sink)[0])[::way]
        for sink, source in system.connections.items()
    ]
    found: set[str] = set()
    new = {owner}
    while new:
        new = {b for a, b in edges if a in new} - found
        found |= new
    return found


def _common(periods: Sequence[Fraction]) -> Fraction:
    below = lcm(*(p.denominator for p in periods))
    return Fraction(lcm(*(int(p * below) for p in periods)), below)
