"""parameters and start are one table, as it is read: of a name the last value holds."""

from typing import Any

from orchestrator.fmu.laid import related
from orchestrator.scenario.takeover import TABLES


def put_last(component: dict[str, Any], table: str, name: str, value: Any) -> None:
    """Set a value in a component's tables so that nothing set before lies over it.

    It stays in its place unless a whole that it is of, or an element, is set too; of
    both tables start is read last.
    """
    other = TABLES[table == "parameters"]
    component.get(other, {}).pop(name, None)
    below = [
        place
        for place in TABLES
        for key in component.get(place, {})
        if key != name and related(key, name)
    ]
    if below:
        component.get(table, {}).pop(name, None)
        table = "start" if "start" in below else table
    component.setdefault(table, {})[name] = value
