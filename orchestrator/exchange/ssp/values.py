"""Parameters and start values of a component as a parameter set (SSV).

A value stands there as the FMU gets it, under the FMU's name.  What a map renames or
scales stands under our name with our value, and a mapping (SSM) says how it becomes
the FMU's: factor * ours + offset, in the arithmetic of our own master.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.xml import Version, add, root
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.start_values import start_values
from orchestrator.fmu.typed import Held
from orchestrator.quantities.unit import Unit
from orchestrator.system import Component

SET = "initialValues"  # one name for all components: Ecos and libcosim choose by it


@dataclass(frozen=True)
class Entry:
    """A parameter of the set; ``port`` is what a mapping brings it to, if one does."""

    name: str
    variable: FmuVariable
    values: tuple[Held, ...]
    unit: Unit | None
    port: Port | None = None


def entries(component: Component, fmu: FmuDescription) -> tuple[Entry, ...]:
    """Return what a component sets, in the order of the scenario.

    Raises:
        WiringError: a value does not fit its variable.
    """
    mapped = {
        name: port
        for name in component.values
        if name in component.map and (port := _scalar(component, fmu, name))
    }
    rest = {k: v for k, v in component.parameters.items() if k not in mapped}
    start = {k: v for k, v in component.start.items() if k not in mapped}
    plain = replace(component, parameters=rest, start=start)
    found = [Entry(v.name, v, values, v.unit) for v, values in start_values(plain, fmu)]
    start_values(component, fmu)  # the mapped ones fit too
    for name, port in mapped.items():
        value = component.values[name]
        assert isinstance(value, float | int)
        found.append(Entry(name, port.variable, (value,), port.unit, port))
    names = [entry.name for entry in found]
    if twice := next((n for n in names if names.count(n) > 1), None):
        raise ScenarioError(
            f"components.{component.name}: {twice!r} is a name of ours for one "
            f"variable and the FMU's own for another, both of which are set; rename "
            f"it in the map"
        )
    return tuple(found)


def _scalar(component: Component, fmu: FmuDescription, name: str) -> Port | None:
    """Return the one real number that a mapped name stands for, if it is that."""
    found = ports(component, fmu, name)
    if len(found) > 1 or found[0].variable.shape or found[0].variable.sort != "real":
        return None
    return found[0]


def parameter_set(found: Iterable[Entry], version: Version) -> Any:
    """Return the document of a parameter set."""
    made = root("ssv:ParameterSet", "ssv", "ssc", version=version, name=SET)
    parameters = add(made, "ssv:Parameters")
    named: dict[str, Unit] = {}
    for entry in found:
        one = add(parameters, "ssv:Parameter", name=entry.name)
        _value(one, entry)
        for size in entry.variable.shape:
            add(one, "ssv:Dimension", size=str(size))
        if entry.unit is not None and entry.unit.base is not None:
            named[str(entry.unit)] = entry.unit
    unit_definitions(made, "ssv:Units", named.values())
    return made


def parameter_mapping(found: Iterable[Entry], version: Version) -> Any | None:
    """Return the document of a mapping, None where nothing is mapped."""
    listed = list(found)
    if all(entry.port is None for entry in listed):
        return None
    made = root("ssm:ParameterMapping", "ssm", "ssc", version=version)
    for entry in listed:
        to = {"source": entry.name, "target": entry.variable.name}
        affine = entry.port.to_theirs if entry.port else None
        if affine is None or not affine.converts:
            add(made, "ssm:MappingEntry", **to)
            continue
        one = add(made, "ssm:MappingEntry", **to, suppressUnitConversion="true")
        add(
            one,
            "ssc:LinearTransformation",
            factor=repr(affine.gain),
            offset=repr(affine.offset),
        )
    return made


def unit_definitions(parent: Any, name: str, units: Iterable[Unit]) -> None:
    """Append the definitions of units, if there are any."""
    defined = {str(unit): unit.base for unit in units if unit.base is not None}
    if not defined:
        return
    listed = add(parent, name)
    for key in sorted(defined):
        base = defined[key]
        assert base is not None
        one = add(listed, "ssc:Unit", name=key)
        of = add(one, "ssc:BaseUnit", **{k: str(n) for k, n in base.exponents.items()})
        if base.factor != 1:
            of.set("factor", repr(base.factor))
        if base.offset:
            of.set("offset", repr(base.offset))


def connector_type(parent: Any, variable: FmuVariable, unit: Unit | None) -> None:
    """Append the element of a connector's type."""
    kind = variable.fmi_type
    made = add(parent, f"ssc:{kind}")
    if variable.sort == "real" and unit is not None and unit.base is not None:
        made.set("unit", str(unit))
    if kind == "Enumeration":
        made.set("name", enumeration_name(variable))


def enumeration_name(variable: FmuVariable) -> str:
    """Return a name that two enumerations share only if they have the same items."""
    return "_".join(f"{item.name}_{item.value}" for item in variable.declared.items)


def enumerations(parent: Any, variables: Iterable[FmuVariable]) -> None:
    """Append the definitions of enumerations, if there are any."""
    found = {enumeration_name(v): v for v in variables if v.fmi_type == "Enumeration"}
    if not found:
        return
    listed = add(parent, "ssd:Enumerations")
    for name in sorted(found):
        one = add(listed, "ssc:Enumeration", name=name)
        for item in found[name].declared.items:
            add(one, "ssc:Item", name=item.name, value=str(item.value))


def _value(parent: Any, entry: Entry) -> None:
    made = add(parent, f"ssv:{entry.variable.fmi_type}")
    texts = [_written(entry.variable, value) for value in entry.values]
    of_texts = ("String", "Binary", "Enumeration")
    if entry.variable.shape and entry.variable.fmi_type in of_texts:
        for text in texts:
            add(made, "ssv:Value", value=text)
    else:
        made.set("value", " ".join(texts) if entry.variable.shape else texts[0])
    unit = entry.unit
    if entry.variable.sort == "real" and unit is not None and unit.base is not None:
        made.set("unit", str(unit))


def _written(variable: FmuVariable, value: Held) -> str:
    if variable.sort == "string":
        return str(value)
    if isinstance(value, bytes):
        return value.hex().upper()
    if variable.sort == "boolean":
        return "true" if value else "false"
    if variable.sort == "real":
        return repr(float(value))
    for item in variable.declared.items:
        if item.value == value:
            return item.name
    return str(value)
