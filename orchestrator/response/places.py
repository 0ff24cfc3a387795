"""Where a composition is excited and observed, and with what periods.

Broken at an output means: what is injected is added for all inputs that it drives.
An input is excited at the instants at which its source publishes, or at its own
component's where nothing drives it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

from orchestrator.errors import ResponseError, WiringError, did_you_mean
from orchestrator.fmu.ports import Port, ports
from orchestrator.master.layout import Link
from orchestrator.master.wiring import links_of
from orchestrator.scenario.compose import Composition
from orchestrator.system import Component, System, split_name


@dataclass(frozen=True)
class Place:
    """One number that is excited: its sinks, and ours to theirs there.

    ``clock`` is the component at whose instants values are added.
    """

    name: str
    unit: str
    sinks: tuple[tuple[str, float], ...]
    clock: str


@dataclass(frozen=True)
class Rates:
    """Periods (s): of what is excited, after which the way repeats, of it all.

    ``way`` are the components in the loops, or between what is excited and observed,
    ``slowest`` those of them with the longest period.
    """

    T: Fraction
    loop: Fraction
    whole: Fraction
    slowest: tuple[str, ...]
    way: frozenset[str]

    @property
    def slow(self) -> int:
        """How many samples of what is excited the way needs to repeat itself."""
        return int(self.loop / self.T)


def broken_at(composition: Composition, name: str) -> Iterator[Place]:
    """Yield the numbers of an output with all inputs that they drive.

    Raises:
        ResponseError: there is no such output, or it drives nothing.
    """
    known = sorted(set(composition.system.connections.values()))
    links = links_of(composition.system, composition.fmus)[0]
    for port in _ports(composition, "break", name, known):
        if port.variable.causality != "output" or not _real(port):
            raise ResponseError(f"break {name}: {port.full_name} is no real output")
        yield _output("break", port, links)


def excited_at(composition: Composition, name: str) -> Iterator[Place]:
    """Yield the numbers of an input, or of an output with all inputs it drives.

    Raises:
        ResponseError: there is none of that name, or it is no real signal.
    """
    system, fmus = composition.system, composition.fmus
    known = [f"{c}.{v}" for c, fmu in fmus.items() for v in fmu.inputs]
    links = links_of(system, fmus)[0]
    sources = {_key(sink): source.component for source, sink, _ in links}
    for port in _ports(composition, "excite", name, known):
        v = port.variable
        if v.causality not in ("input", "output") or not _real(port):
            raise ResponseError(
                f"excite {name}: {port.full_name} is no real input or output but a "
                f"{v.sort} {v.causality}; name an input, say {known[0]}"
            )
        if v.causality == "output":
            yield _output("excite", port, links)
        else:
            clock = sources.get(_key(port), port.component)
            own = ((port.full_name, 1.0),)
            yield Place(port.full_name, port.unit or "1", own, clock)


def observed_at(composition: Composition, name: str) -> Iterator[tuple[str, str]]:
    """Yield the numbers of a signal and their units.

    Raises:
        ResponseError: there is none of that name, or it is no real signal.
    """
    fmus = composition.fmus
    known = [
        f"{c}.{n}"
        for c, fmu in fmus.items()
        for n, v in fmu.variables.items()
        if v.causality == "output"
    ]
    for port in _ports(composition, "observe", name, known):
        v = port.variable
        if v.causality not in ("input", "output", "local") or not _real(port):
            raise ResponseError(
                f"observe {name}: {port.full_name} is no real signal but a {v.sort} "
                f"{v.causality}; name an output, say {known[0]}"
            )
        yield port.full_name, port.unit or "1"


def _ports(
    composition: Composition, option: str, name: str, known: Sequence[str]
) -> list[Port]:
    system = composition.system
    owner, variable = split_name(name)
    noun = {"break": "output", "excite": "input or output", "observe": "signal"}[option]
    refusal = f"{option} {name}: no such {noun}; {did_you_mean(name, known)}"
    if owner not in system.components or not variable:
        raise ResponseError(refusal)
    try:
        return ports(system.components[owner], composition.fmus[owner], variable)
    except WiringError as error:
        raise ResponseError(f"{option} {name}: {error}") from None


def _output(option: str, port: Port, links: Sequence[Link]) -> Place:
    sinks = tuple(
        (sink.full_name, affine.gain / (source.to_ours.gain * sink.to_theirs.gain))
        for source, sink, affine in links
        if _key(source) == _key(port)
    )
    if not sinks:
        raise ResponseError(
            f"{option} {port.full_name}: {port.full_name} drives nothing"
        )
    return Place(port.full_name, port.unit or "1", sinks, port.component)


def _real(port: Port) -> bool:
    return port.variable.sort == "real" and port.variable.dtype == "float64"


def _key(port: Port) -> tuple[str, str, int]:
    return port.component, port.variable.name, port.element


def rates_of_loops(system: System, breaks: Sequence[Place]) -> Rates:
    """Return the periods of the loops through some outputs.

    Raises:
        ResponseError: one is in no loop, or their periods differ.
    """
    owners = _of_one_clock("break", system, breaks)
    loop: set[str] = set()
    for owner in owners:
        found = _reached(system, owner, 1) & _reached(system, owner, -1)
        if owner not in found:
            raise ResponseError(
                f"break {owner}: no connection leads back to it, so there is no loop"
            )
        loop |= found
    return _rates(system, owners[0], loop)


def rates_of_ways(
    system: System, excited: Sequence[Place], observed: Sequence[str]
) -> Rates:
    """Return the periods of all that lies between inputs and outputs.

    Raises:
        ResponseError: nothing leads from one to the other, or their periods differ.
    """
    owners = _of_one_clock("excite", system, excited)
    starts = {split_name(sink)[0] for e in excited for sink, _ in e.sinks}
    ends = {split_name(name)[0] for name in observed}
    after = starts.union(*(_reached(system, name, 1) for name in starts))
    before = ends.union(*(_reached(system, name, -1) for name in ends))
    for name in ends - after:
        raise ResponseError(
            f"observe {name}: no connection leads there from "
            f"{', '.join(e.name for e in excited)}"
        )
    return _rates(system, owners[0], after & before)


def _of_one_clock(option: str, system: System, places: Sequence[Place]) -> list[str]:
    owners = list(dict.fromkeys(place.clock for place in places))
    parts: list[Component] = [system.components[name] for name in owners]
    if len({(part.period, part.offset) for part in parts}) > 1:
        names = ", ".join(place.name for place in places)
        raise ResponseError(
            f"{option} {names}: their components have different periods or offsets; "
            f"{option} what is of one clock together"
        )
    return owners


def _rates(system: System, clock: str, way: set[str]) -> Rates:
    parts = system.components
    slowest = max(parts[name].period for name in way)
    return Rates(
        parts[clock].period,
        _common([parts[name].period for name in {*way, clock}]),
        _common([part.period for part in parts.values()]),
        tuple(sorted(name for name in way if parts[name].period == slowest)),
        frozenset(way),
    )


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
