"""Connections and records written with a star, opened to single variables.

One ``*`` stands for any text, the same on both sides.  A line for a single
variable wins over a star; a source that is a number becomes a start value.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import ports
from orchestrator.scenario.schema import Source, Specification
from orchestrator.system import Component, Value, split_name
from orchestrator.warned import warn

Constants: TypeAlias = dict[str, dict[str, Value]]  # where it is written -> name


def open_connections(
    spec: Specification,
    components: Mapping[str, Component],
    fmus: Mapping[str, FmuDescription],
) -> tuple[dict[str, str], dict[str, dict[str, Value]]]:
    """Return connections by sink with stars opened, and constants by component.

    Raises:
        WiringError: a star connects nothing or an input twice, a constant goes to
            what is no input.
    """
    opened: dict[str, str | float] = {}
    for sink, source in spec.connections.items():
        if "*" not in sink:
            if isinstance(source, tuple) or (isinstance(source, str) and "*" in source):
                raise WiringError(
                    f"connections.{sink!r}: a single input takes a single source, "
                    f"not {source!r}"
                )
            opened[sink] = source
    for sink, source in spec.connections.items():
        if "*" in sink:
            found = dict(_open(sink, source, components, fmus))
            if not found:
                raise WiringError(
                    f"connections.{sink!r} = {source!r}: no input there has the name "
                    f"of an output here"
                )
            twice = [s for s in found if s in opened and s not in spec.connections]
            if twice:
                raise WiringError(f"connections.{sink!r}: drives {twice[0]} again")
            opened = {**found, **opened}
    connections = {k: v for k, v in opened.items() if isinstance(v, str)}
    constants: dict[str, dict[str, Value]] = {}
    for sink, source in opened.items():
        if not isinstance(source, str):
            component, variable = split_name(sink)
            _refuse_no_input(sink, components[component], fmus[component])
            constants.setdefault(component, {})[variable] = source
    return connections, constants


def constants_of(
    connections: Mapping[str, Source], component: Component, fmu: FmuDescription
) -> Constants:
    """Return a component's constants by the sinks they are written at."""
    ends = [(*split_name(sink), source) for sink, source in connections.items()]
    own = {name: source for owner, name, source in ends if owner == component.name}
    found: Constants = {}
    for name, source in own.items():
        if isinstance(source, str | tuple):
            continue
        inputs = names(component, fmu, "input") if "*" in name else ()
        opened = [
            n
            for n in inputs
            if _match(name, n) is not None
            and n not in own
            and not _variable(component, fmu, n).is_text
        ]
        found[name] = dict.fromkeys(opened if "*" in name else [name], source)
    return found


def _variable(component: Component, fmu: FmuDescription, name: str) -> FmuVariable:
    return fmu.variables[component.map[name].name if name in component.map else name]


def _open(
    sink: str,
    source: float | str | tuple[str, ...],
    components: Mapping[str, Component],
    fmus: Mapping[str, FmuDescription],
) -> Iterator[tuple[str, str | float]]:
    component, pattern = split_name(sink)
    sources = source if isinstance(source, tuple) else (source,)
    inputs = _numbers(components[component], fmus[component], "input", sink)
    for name in inputs:
        star = _match(pattern, name)
        if star is None:
            continue
        for candidate in sources:
            if not isinstance(candidate, str):
                yield f"{component}.{name}", candidate
                break
            owner, output = split_name(candidate.replace("*", star))
            if output in names(components[owner], fmus[owner], "output"):
                yield f"{component}.{name}", f"{owner}.{output}"
                break


def _match(pattern: str, name: str) -> str | None:
    """Return the text that the one ``*`` of a pattern stands for."""
    before, _, after = pattern.partition("*")
    long_enough = len(name) >= len(before) + len(after)
    if long_enough and name.startswith(before) and name.endswith(after):
        return name[len(before) : len(name) - len(after)]
    return None


def names(component: Component, fmu: FmuDescription, causality: str) -> list[str]:
    """Return a component's inputs or outputs by the names a scenario uses."""
    theirs = {mapped.name: ours for ours, mapped in component.map.items()}
    found = fmu.inputs if causality == "input" else fmu.outputs
    return [theirs.get(name, name) for name in found]


def _numbers(
    component: Component, fmu: FmuDescription, causality: str, star: str
) -> list[str]:
    """Return the names a star may stand for; of texts that it leaves out it warns."""
    _, pattern = split_name(star)
    found = []
    for name in names(component, fmu, causality):
        variable = _variable(component, fmu, name)
        if not variable.is_text:
            found.append(name)
        elif _match(pattern, name) is not None:
            warn(
                f"{star!r} leaves out {component.name}.{name}, which is "
                f"{variable.kind}: texts travel where a connection names both ends"
            )
    return found


def _refuse_no_input(sink: str, component: Component, fmu: FmuDescription) -> None:
    _, variable = split_name(sink)
    for port in ports(component, fmu, variable):
        if port.variable.causality != "input":
            known = names(component, fmu, "input")
            raise WiringError(
                f"connections.{sink!r}: {variable} is no input of {component.name}; "
                f"{did_you_mean(variable, known)}"
            )


def open_record(
    spec: Specification,
    components: Mapping[str, Component],
    fmus: Mapping[str, FmuDescription],
    last: Sequence[str] = (),
) -> dict[str, tuple[Fraction, ...]]:
    """Return the row periods of each recorded variable; a star takes all outputs.

    A line for a single variable wins over a star, and over both one of ``last``.

    Raises:
        WiringError: no output fits the star.
    """
    record: dict[str, tuple[Fraction, ...]] = {}
    lines: dict[str, tuple[bool, bool]] = {}
    for variable, rows in spec.record.items():
        component, pattern = split_name(variable)
        part = components[component]
        wanted = [pattern]
        if "*" in pattern:
            outputs = _numbers(part, fmus[component], "output", variable)
            wanted = [n for n in outputs if _match(pattern, n) is not None]
            if not wanted:
                raise WiringError(
                    f"record.{variable!r}: {component} has no such output; "
                    f"{did_you_mean(pattern, outputs)}"
                )
        line = variable in last, "*" not in pattern
        for name in (f"{component}.{n}" for n in wanted):
            if line >= lines.get(name, line):
                periods = (row or part.period for row in rows)
                record[name] = tuple(dict.fromkeys(periods))
                lines[name] = line
    return record
