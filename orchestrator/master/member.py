"""One member of a series: the same system with other parameters and start values."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

from orchestrator.fmu.laid import laid
from orchestrator.fmu.start_values import start_values
from orchestrator.master.layout import Part
from orchestrator.master.timetable import Timetable
from orchestrator.system import Value

Values: TypeAlias = Mapping[str, Mapping[str, Value]]  # component -> name -> value


def part_with(part: Part, given: Mapping[str, Value]) -> Part:
    """Return a part whose component has these values besides its own.

    Raises:
        WiringError: a value names no variable, or does not fit it.
    """
    component = laid(part.component, part.fmu, given)
    written = start_values(component, part.fmu)
    return replace(part, component=component, start=written)


def timetable_with(timetable: Timetable, values: Values) -> Timetable:
    """Return the timetable of a member; when and in which order stays.

    Raises:
        WiringError: a value names no variable, or does not fit it.
    """
    parts = dict(timetable.wiring.parts)
    for name, given in values.items():
        parts[name] = part_with(parts[name], given)
    member = replace(timetable, wiring=replace(timetable.wiring, parts=parts))
    for known in ("schedule", "_ordered"):
        if known in timetable.__dict__:
            member.__dict__[known] = timetable.__dict__[known]
    return member
