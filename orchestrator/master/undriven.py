"""Inputs that no connection drives: what they hold from the first instant on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from orchestrator.errors import WiringError
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.start_values import declared, start_values
from orchestrator.system import Component, System, split_name


@dataclass(frozen=True)
class Undriven:
    """An input by our name and the value it keeps, in our unit.

    ``given`` tells that the scenario says that value, and not the FMU alone.
    """

    input: str
    value: float
    unit: str
    given: bool

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.input} = {self.value:.6g}{unit}"


def undriven(
    system: System, fmus: Mapping[str, FmuDescription]
) -> tuple[Undriven, ...]:
    """Return the numbers of all inputs that no connection drives.

    Texts and binaries, which are never driven, are not among them.
    """
    driven = {
        (port.component, port.variable.name, port.element)
        for sink in system.connections
        for port in _ports(system, fmus, sink)
    }
    return tuple(
        one
        for name, component in system.components.items()
        for one in _held(component, fmus[name], driven)
    )


def _held(
    component: Component, fmu: FmuDescription, driven: set[tuple[str, str, int]]
) -> Iterator[Undriven]:
    written = {v.name: numbers for v, numbers in start_values(component, fmu)}
    ours = {mapped.name: name for name, mapped in component.map.items()}
    for name in fmu.inputs:
        for port in ports(component, fmu, ours.get(name, name)):
            v = port.variable
            free = (component.name, v.name, port.element) not in driven
            if free and not v.is_text:
                numbers = written.get(v.name) or declared(v) or [0.0] * v.size
                value, affine = numbers[port.element], port.to_ours
                assert isinstance(value, float | int)
                if affine.converts:
                    value = affine.gain * value + affine.offset
                given = v.name in written
                yield Undriven(port.full_name, value, str(port.unit or "1"), given)


def _ports(system: System, fmus: Mapping[str, FmuDescription], full: str) -> list[Port]:
    owner, name = split_name(full)
    try:
        return ports(system.components[owner], fmus[owner], name)
    except (KeyError, WiringError):  # refused when the system is wired
        return []


def in_words(found: tuple[Undriven, ...]) -> str:
    """Return what is held at a start value of an FMU, in words; "" if nothing is."""
    held = [str(one) for one in found if not one.given]
    return f"nothing drives {', '.join(held)}: start values hold" if held else ""
