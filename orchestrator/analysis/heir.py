"""A scenario that inherits from another and has values that were found."""

from collections.abc import Mapping
from os.path import relpath
from pathlib import Path

from orchestrator.scenario.compose import Composition
from orchestrator.system import split_name


def write_heir(
    composition: Composition, values: Mapping[str, float], title: str, target: Path
) -> Path:
    """Write a scenario that has these values besides those of a composition's own."""
    import tomli_w

    components: dict[str, dict[str, dict[str, float]]] = {}
    for name, value in values.items():
        component, variable = split_name(name)
        table = "start" if variable.startswith("state.") else "parameters"
        tables = components.setdefault(component, {})
        tables.setdefault(table, {})[variable] = value
    scenario = composition.scenario
    base = Path(relpath(scenario.file.resolve(), target.parent.resolve())).as_posix()
    target.parent.mkdir(parents=True, exist_ok=True)
    written = {
        "base": scenario.name if "/" in scenario.name else base,
        "title": title,
        "components": components,
    }
    target.write_bytes(tomli_w.dumps(written).encode())
    return target
