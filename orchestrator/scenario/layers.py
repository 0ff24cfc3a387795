"""The layers of a component's values: of every number the last one holds.

design step < scenario file < constants of connections < --set, in its order
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.laid import laid, numbers, related, same_numbers
from orchestrator.scenario.stars import Constants
from orchestrator.system import Component, Value
from orchestrator.warned import warn

Settings = Sequence[tuple[bool, str]]  # whether of a connection, and the name


def layered(
    component: Component,
    fmu: FmuDescription,
    designed: Mapping[str, Value],
    constants: Constants,
    settings: Settings = (),
) -> Component:
    """Return a component, which has the scenario's values, with those of all layers.

    ``constants`` are by the name on the connection, ``settings`` what ``--set`` gave.

    Raises:
        ScenarioError: two names of one number are set in one layer.
    """
    by_set = {name for constant, name in settings if not constant}
    own = [name for name in component.values if name not in by_set]
    of_connections = {n: v for values in constants.values() for n, v in values.items()}
    refuse_two_names(component, fmu, own)
    refuse_two_names(component, fmu, of_connections)
    found = laid(replace(component, parameters={}, start={}), fmu, designed)
    found = laid(found, fmu, component.parameters, "parameters")
    found = laid(found, fmu, component.start, "start")
    last = {line for constant, line in settings if constant}
    for line, values in constants.items():
        if line not in last:
            _say_without_effect(component, fmu, own, values)
            found = laid(found, fmu, values, "start")
    for constant, name in settings:
        if constant:
            found = laid(found, fmu, constants.get(name, {}), "start")
        elif name in component.values:
            table = "start" if name in component.start else "parameters"
            found = laid(found, fmu, {name: component.values[name]}, table)
    return found


def refuse_two_names(
    component: Component, fmu: FmuDescription, names: Iterable[str]
) -> None:
    """Raise ``ScenarioError`` if two names of a map's making stand for one number."""
    known: list[str] = []
    for name in names:
        for other in same_numbers(component, fmu, name, known):
            if not related(name, other):
                theirs = min(numbers(component, fmu, name))[0]
                raise ScenarioError(
                    f"components.{component.name}: {other} and {name} are both set, "
                    f"and by the map both stand for {theirs} of {fmu.path.name}; "
                    f"remove one of the two"
                )
        known.append(name)


def _say_without_effect(
    component: Component,
    fmu: FmuDescription,
    own: Iterable[str],
    constants: Mapping[str, Value],
) -> None:
    names = list(own)
    for name, value in constants.items():
        for other in same_numbers(component, fmu, name, names):
            if (other, component.values[other]) != (name, value):
                warn(
                    f"{component.name}.{other} is set, but the constant "
                    f"connections.{component.name}.{name} = {value} holds: set it there"
                )
