"""Values that a scenario writes with a unit: ``m = "8 kg"``.

They become numbers in the unit of the variable on our side, before anything else
looks at them.
"""

from collections.abc import Mapping

from fmus.units import UnitError, base_unit
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import ports
from orchestrator.quantities.quantity import parse_quantity
from orchestrator.quantities.unit import Unit, conversion
from orchestrator.system import Component, Value
from orchestrator.warned import warn


def in_own_units(
    component: Component,
    fmu: FmuDescription,
    table: str,
    values: Mapping[str, Value],
) -> dict[str, Value]:
    """Return the values of a component's table, quantities as numbers.

    Raises:
        ScenarioError: a text is no number with a unit, or does not fit the variable.
    """
    return {
        name: _number(component, fmu, f"components.{component.name}.{table}", name, v)
        if isinstance(v, str)
        else v
        for name, v in values.items()
    }


def _number(
    component: Component, fmu: FmuDescription, table: str, name: str, text: str
) -> float | str:
    where = f'{table}.{name} = "{text}"'
    try:
        port = ports(component, fmu, name)[0]
        if port.variable.is_text or port.variable.declared.items:
            return text  # of its own type
        given, unit = parse_quantity(text), port.unit
    except (ValueError, WiringError) as error:
        raise ScenarioError(f"{where}: {error}") from None
    if unit is None:
        raise ScenarioError(f"{where}: it has no unit there; give the number alone")
    try:
        read = Unit(given.unit, base_unit(given.unit, fmu.units))
        gain, offset, doubts = conversion(read.of_difference(unit.relative), unit)
    except UnitError as error:
        raise ScenarioError(f"{where}: {error}") from None
    for doubt in doubts:
        warn(f"{where}: {doubt}")
    return gain * given.value + offset
