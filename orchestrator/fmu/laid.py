"""Values laid over one another, by the numbers of the FMU that their names stand for.

A name stands for one number, for all of an array or record, or by a map for what has
the FMU's own name too.  Of every number the value that was laid last holds: a whole
takes the place of its elements, an element lies over the whole it is of.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from orchestrator.errors import WiringError
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import Port, ports
from orchestrator.system import Component, Scalar, Value

Numbers: TypeAlias = frozenset[tuple[str, int]]  # variables of the FMU and elements


def related(one: str, other: str) -> bool:
    """Tell whether of two names, as they are written, one is part of the other."""
    low, high = sorted((one, other), key=len)
    return low == high or high.startswith((f"{low}[", f"{low}."))


def numbers(component: Component, fmu: FmuDescription, name: str) -> Numbers:
    """Return what a name stands for; nothing where it is refused when wired."""
    try:
        return frozenset(
            (port.variable.name, port.element) for port in ports(component, fmu, name)
        )
    except WiringError:
        return frozenset()


def same_numbers(
    component: Component, fmu: FmuDescription, name: str, others: Iterable[str]
) -> dict[str, Numbers]:
    """Return those of ``others`` that share a number with ``name``, and all theirs."""
    near = [one for one in others if _head(component, one) == _head(component, name)]
    own = numbers(component, fmu, name) if near else frozenset()
    all_of = {one: numbers(component, fmu, one) for one in near}
    return {one: theirs for one, theirs in all_of.items() if theirs & own}


def _head(component: Component, name: str) -> str:
    """Return what all names of one number begin with in the FMU."""
    return _first(component.map[name].name if name in component.map else name)


def _first(theirs: str) -> str:
    return re.split(r"[.\[]", theirs, maxsplit=1)[0]


def laid(
    component: Component,
    fmu: FmuDescription,
    given: Mapping[str, Value],
    table: str | None = None,
) -> Component:
    """Return a component with values over its own, in the order of writing.

    They go to ``table``, else where a value of that name stands, else to parameters.

    Raises:
        WiringError: one is part of an array that is set by another name in the map.
    """
    tables = {"parameters": dict(component.parameters), "start": dict(component.start)}
    for name, value in given.items():
        where = {key: t for t, values in tables.items() for key in values}
        below = same_numbers(component, fmu, name, where.keys() - {name})
        own = numbers(component, fmu, name) if below else frozenset()
        for other, theirs in below.items():
            if theirs <= own:
                del tables[where[other]][other]
            elif not related(name, other):
                raise WiringError(
                    f"{component.name}.{name} is part of {component.name}.{other}, "
                    f"which is set and is named so in the map; set {other} whole"
                )
        kept = {where[other] for other in below if other in tables[where[other]]}
        place = table or where.get(name, "parameters")
        if kept:
            place = "start" if "start" in kept else place
        for t, values in tables.items():
            if kept or t != place:
                values.pop(name, None)
        tables[place][name] = value
    return replace(component, parameters=tables["parameters"], start=tables["start"])


def held_on(
    component: Component,
    fmu: FmuDescription,
    found: Sequence[Port],
    given: Mapping[str, Value],
) -> list[Scalar | None]:
    """Return what values, laid in their order, make of each number, in the unit of its
    port; None where nothing is laid on it.

    Raises:
        WiringError: a name has not as many values as it stands for.
    """
    held: dict[tuple[str, int], tuple[Port, Scalar]] = {}
    asked = {_first(port.variable.name) for port in found}
    for name, value in given.items():
        if _head(component, name) not in asked:
            continue
        own = ports(component, fmu, name)
        each = value if isinstance(value, tuple) else (value,)
        if len(each) != len(own):
            raise WiringError(
                f"{component.name}.{name}: {len(own)} values expected, "
                f"{len(each)} given"
            )
        for port, one in zip(own, each, strict=True):
            held[port.variable.name, port.element] = port, one
    pairs = [held.get((port.variable.name, port.element)) for port in found]
    return [
        None if pair is None else _as_read_by(port, *pair)
        for port, pair in zip(found, pairs, strict=True)
    ]


def _as_read_by(asked: Port, port: Port, value: Scalar) -> Scalar:
    """Return a value of one name's unit in that of another name."""
    same = (port.gain, port.offset) == (asked.gain, asked.offset)
    if same or isinstance(value, str):
        return value
    affine = port.to_theirs.then(asked.to_ours)
    return affine.gain * value + affine.offset
