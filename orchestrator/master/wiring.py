"""A system checked against its FMUs, its connections resolved.

Refused here: unknown names, two sorts or units that do not fit, what is no input;
by ``asked`` what an FMU is not, by ``groups`` and ``texts`` what these cannot be.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import Port, connection, ports
from orchestrator.fmu.typed import held
from orchestrator.master.asked import experiment_notes, refuse_unfit
from orchestrator.master.groups import groups_of
from orchestrator.master.layout import (
    Column,
    Edge,
    Faulty,
    Injected,
    Layout,
    Link,
    Wiring,
)
from orchestrator.master.texts import texts_of
from orchestrator.system import Fault, System, split_name


def wire(system: System, fmus: Mapping[str, FmuDescription]) -> Wiring:
    """Check a system against its FMUs and lay it out.

    Raises:
        WiringError, ScheduleError: see the contract above.
    """
    for name, component in system.components.items():
        refuse_unfit(system, component, fmus[name])
    links, notes, warnings = links_of(system, fmus)
    for name, component in system.components.items():
        warnings += experiment_notes(component, fmus[name])
    recorded = {
        name: _ports_of(system, fmus, name, f"record.{name!r}")
        for name in system.record
    }
    for name, found in recorded.items():
        for port in found:
            if port.variable.is_text:
                raise WiringError(
                    f"record.{name!r}: {port.full_name} is {port.variable.kind}, and "
                    f"texts are not recorded; remove it from [record]"
                )
    injected = {name: _injected_port(system, fmus, name) for name in system.injections}
    layout = Layout(system, fmus, links, recorded, list(injected.values()))
    parts = {name: layout.part(name) for name in system.components}
    taken = [port for found in recorded.values() for port in found]
    taken += _written(system, fmus)
    warnings += [doubt for port in taken for doubt in port.doubts]
    edges = tuple(
        Edge(s.component, s.variable.name, t.component, t.variable.name)
        for s, t, _ in links
    )
    tables: dict[Fraction, list[Column]] = {}
    for name, found in recorded.items():
        for period in system.record[name]:
            columns = tables.setdefault(period, [])
            columns.extend(layout.column(port) for port in found)
    faulty = tuple(_faulty(system, fmus, layout))
    additions = tuple(_injected(system, layout, injected))
    return Wiring(
        system,
        parts,
        tuple(dict.fromkeys(edges)),
        {period: tuple(columns) for period, columns in tables.items()},
        layout.size,
        tuple(notes),
        tuple(dict.fromkeys(warnings)),
        faulty,
        additions,
        tuple(groups_of(system, parts, faulty, additions)),
        tuple(texts_of(system, links)),
    )


def _written(system: System, fmus: Mapping[str, FmuDescription]) -> list[Port]:
    """Return the numbers that are written before the run."""
    return [
        port
        for name, component in system.components.items()
        for variable in (*component.parameters, *component.start)
        for port in ports(component, fmus[name], variable)
    ]


def _faulty(
    system: System, fmus: Mapping[str, FmuDescription], layout: Layout
) -> Iterator[Faulty]:
    """Yield every place of an input that has faults.

    Raises:
        WiringError: no connection leads there, or a number is computed of a switch.
    """
    brought = {
        (t.component, t.variable.name, t.element): Edge(
            s.component, s.variable.name, t.component, t.variable.name
        )
        for s, t, _ in layout.links
    }
    for name, faults in system.faults.items():
        where = f"faults.{name!r}"
        for port in _ports_of(system, fmus, name, where):
            key = (port.component, port.variable.name)
            if port.variable.is_text:
                raise WiringError(
                    f"{where}: {port.full_name} is {port.variable.kind}, and no fault "
                    f"acts on texts; remove it"
                )
            if port.whole is not None:
                raise WiringError(
                    f"{where}: {port.full_name} is rounded or looked up by its map, "
                    f"on which no fault acts; put the fault before a component that "
                    f"does it"
                )
            edge = brought.get((*key, port.element))
            if edge is None:
                known = {f"{e.sink}.{e.input}" for e in brought.values()}
                raise WiringError(
                    f"{where}: no connection leads to {port.full_name}; "
                    f"{did_you_mean(name, known)}"
                )
            if port.variable.sort != "real" and (
                kinds := {f.kind for f in faults} & {"bias", "gain", "quantisation"}
            ):
                raise WiringError(
                    f"{where}: {port.full_name} is {port.variable.sort}, which has no "
                    f"{' or '.join(sorted(kinds))}; use stuck, delay or override"
                )
            _refuse_override(where, port, faults, fmus[port.component])
            place = layout.input_at[key] + port.element
            yield Faulty(edge, place, port.variable.dtype, port.to_theirs, faults)


def _injected_port(
    system: System, fmus: Mapping[str, FmuDescription], name: str
) -> Port:
    """Return the one real input that an injection names.

    Raises:
        WiringError: it is none, or several.
    """
    where = f"injections.{name!r}"
    found = _ports_of(system, fmus, name, where)
    if len(found) != 1:
        raise WiringError(
            f"{where}: stands for {len(found)} numbers; name one, such as "
            f"{found[0].full_name if found else name}"
        )
    v = found[0].variable
    if v.causality != "input" or v.sort != "real" or v.dtype != "float64":
        raise WiringError(
            f"{where}: a {v.sort} {v.causality}; signals are injected at real inputs"
        )
    return found[0]


def _injected(
    system: System, layout: Layout, ports: Mapping[str, Port]
) -> Iterator[Injected]:
    for name, port in ports.items():
        key = (port.component, port.variable.name)
        of = layout.source_of.get((*key, port.element), port.component)
        gain = port.to_theirs.gain
        values = tuple(gain * v for v in system.injections[name].values)
        place = layout.input_at[key] + port.element
        yield Injected(of, port.component, place, values)


def _refuse_override(
    where: str, port: Port, faults: Sequence[Fault], fmu: FmuDescription
) -> None:
    """Refuse a value that the input does not take, and a scaled 64-bit integer."""
    for fault in faults:
        if fault.kind == "override":
            held(f"{where}.value", port, fault.value, fmu.fmi_major)
    if port.variable.dtype != "float64" and port.to_theirs.converts:
        raise WiringError(
            f"{where}: {port.full_name} is a 64-bit integer that a map scales, on "
            f"which no fault acts; remove the gain of the map"
        )


def links_of(
    system: System, fmus: Mapping[str, FmuDescription]
) -> tuple[list[Link], list[str], list[str]]:
    """Return every number that is connected, notes and what is a guess.

    Raises:
        WiringError: names, types or units do not fit, or an input is driven twice.
    """
    links: list[Link] = []
    notes: list[str] = []
    warnings: list[str] = []
    driven: dict[tuple[str, str, int], str] = {}
    for sink, source in system.connections.items():
        where = f"connections.{sink!r} = {source!r}"
        targets = _ports_of(system, fmus, sink, where)
        origins = _ports_of(system, fmus, source, where)
        for origin, target in _pairs(origins, targets, where):
            v = target.variable
            tunable = v.causality == "parameter" and v.variability == "tunable"
            if v.causality != "input" and not tunable:
                raise WiringError(
                    f"{where}: {target.full_name} is no input and no tunable "
                    f"parameter but a {v.variability} {v.causality}; inputs of "
                    f"{target.component}: "
                    f"{', '.join(fmus[target.component].inputs) or 'none'}"
                )
            key = (target.component, target.variable.name, target.element)
            if key in driven:
                raise WiringError(
                    f"{where}: {target.full_name} is already driven by {driven[key]}; "
                    f"remove one of the two"
                )
            driven[key] = origin.full_name
            affine, note, doubts = connection(origin, target)
            links.append((origin, target, affine))
            notes.extend([note] if note else [])
            warnings.extend(doubts)
    return links, notes, warnings


def _pairs(
    origins: Sequence[Port], targets: Sequence[Port], where: str
) -> list[tuple[Port, Port]]:
    if len(origins) == len(targets) == 1:
        return [(origins[0], targets[0])]
    by_label = {port.label: port for port in origins}
    missing = [t.label for t in targets if t.label not in by_label]
    if missing or len(origins) != len(targets):
        raise WiringError(
            f"{where}: {len(origins)} values for {len(targets)}"
            + (f", none for {', '.join(missing)}" if missing else "")
            + "; connect arrays of one shape or records with the same fields"
        )
    return [(by_label[t.label], t) for t in targets]


def _ports_of(
    system: System, fmus: Mapping[str, FmuDescription], full: str, where: str
) -> list[Port]:
    owner, name = split_name(full)
    if owner not in system.components:
        raise WiringError(
            f"{where}: no component {owner!r}; {did_you_mean(owner, system.components)}"
        )
    if not name:
        raise WiringError(f"{where}: write component.variable, not {full!r}")
    try:
        return ports(system.components[owner], fmus[owner], name)
    except WiringError as error:
        raise WiringError(f"{where}: {error}") from None
