"""The connections of a system, bundled by the two components they join.

What the wiring shows and the verb ``wiring`` lists: unit, gain and age of each.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import groupby
from typing import NamedTuple

from orchestrator.fmu.ports import Port
from orchestrator.master.ages import Age, explained
from orchestrator.master.faults import describe
from orchestrator.master.layout import Link
from orchestrator.master.timetable import Timetable
from orchestrator.master.wiring import links_of

MOST = 6  # lines of a bundle in a picture


class Wire(NamedTuple):
    """One number that is connected: the ends by our names, units, what is done to it.

    ``youngest`` and ``oldest`` are its ages (s) when it is taken.
    """

    source: str
    sink: str
    unit: str
    unit_there: str
    gain: float
    offset: float
    youngest: Fraction
    oldest: Fraction
    faults: tuple[str, ...]

    @property
    def output(self) -> str:
        return self.source.partition(".")[2]

    @property
    def input(self) -> str:
        return self.sink.partition(".")[2]

    @property
    def conversion(self) -> str:
        """Return unit, and what else there is: ``mm → m, × 0.001``."""
        units = self.unit if self.unit == self.unit_there else self.units
        told = [units] if units else []
        told += [f"× {self.gain:.6g}"] if self.gain != 1 else []
        told += [f"{self.offset:+.6g}"] if self.offset else []
        return ", ".join((*told, *self.faults))

    @property
    def units(self) -> str:
        return f"{self.unit or 'no unit'} → {self.unit_there or 'no unit'}"


class Bundle(NamedTuple):
    """All wires from one component to another."""

    source: str
    sink: str
    wires: tuple[Wire, ...]

    @property
    def ages(self) -> tuple[Fraction, Fraction]:
        """Return the least and the greatest age (s) in it."""
        return min(w.youngest for w in self.wires), max(w.oldest for w in self.wires)

    def lines(self) -> list[str]:
        """Return what is written beside it: signals with units, what repeats as one."""
        told = [_line(list(same)) for _, same in groupby(self.wires, _shared)]
        if len(told) > MOST:
            left = len(told) - MOST + 1
            return [*told[: MOST - 1], f"and {left} more"]
        return told


def wires(timetable: Timetable) -> Iterator[Wire]:
    """Yield every number that is connected, in the order of the connections."""
    wiring = timetable.wiring
    fmus = {name: part.fmu for name, part in wiring.parts.items()}
    ages = dict(zip(wiring.edges, explained(timetable).ages, strict=True))
    by_ends = {(e.source, e.output, e.sink, e.input): a for e, a in ages.items()}
    for link in links_of(wiring.system, fmus)[0]:
        yield _wire(link, by_ends, timetable)


def bundles(timetable: Timetable) -> list[Bundle]:
    """Return the wires by the components they join."""
    found: dict[tuple[str, str], list[Wire]] = {}
    for wire in wires(timetable):
        ends = wire.source.partition(".")[0], wire.sink.partition(".")[0]
        found.setdefault(ends, []).append(wire)
    return [Bundle(*ends, tuple(of)) for ends, of in found.items()]


def _wire(
    link: Link, ages: dict[tuple[str, str, str, str], Age], timetable: Timetable
) -> Wire:
    source, sink, affine = link
    ends = source.component, source.variable.name, sink.component, sink.variable.name
    faults = timetable.wiring.system.faults.get(sink.full_name, ())
    return Wire(
        source.full_name,
        sink.full_name,
        _unit(source),
        _unit(sink),
        affine.gain,
        affine.offset,
        ages[ends].youngest,
        ages[ends].oldest,
        tuple(f"fault: {describe(fault)}" for fault in faults),
    )


def _unit(port: Port) -> str:
    return "" if port.unit is None or str(port.unit) == "1" else str(port.unit)


def _stem(name: str) -> str:
    """Return the array or record a name is of; the name itself if of none."""
    return name[: min((i for i in map(name.find, "[.") if i > 0), default=len(name))]


def _shared(wire: Wire) -> tuple[object, ...]:
    return _stem(wire.output), _stem(wire.input), wire[2:]


def _line(same: Sequence[Wire]) -> str:
    first = same[0]
    there, here = first.output, first.input
    if len(same) > 1:
        there, here = (f"{_stem(name)}.*" for name in (there, here))
        there = f"{len(same)} of {there}"
    name = there if first.output == first.input else f"{there} → {here}"
    if not first.conversion:
        return name
    return (
        f"{name} in {first.conversion}" if first.unit else f"{name} {first.conversion}"
    )
