"""A scenario that inherits from another and has values that were found.

They were found with the designs as they are.  In a file they would be what designs
are told: so steps that are ``kept`` are told the old values, written as arguments.
"""

from collections.abc import Collection, Mapping
from os.path import relpath
from pathlib import Path
from typing import Any

from orchestrator.analysis.members import numbers
from orchestrator.scenario.compose import Composition
from orchestrator.system import split_name


def write_heir(
    composition: Composition,
    values: Mapping[str, float],
    title: str,
    target: Path,
    kept: Collection[str] | None = None,
) -> Path:
    """Write a scenario that has these values besides those of a composition's own.

    Design steps that are ``kept``, all if it is None, are told what they were told.
    """
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
    written: dict[str, Any] = {
        "base": scenario.name if "/" in scenario.name else base,
        "title": title,
        "components": components,
    }
    if told := _told(composition, values, kept):
        written["design"] = told
    target.write_bytes(tomli_w.dumps(written).encode())
    return target


def read_by(composition: Composition, values: Collection[str]) -> dict[str, list[str]]:
    """Return for each design step which of its arguments read one of some values."""
    found = {name for value in values for name in numbers(composition, value)}
    steps = composition.scenario.spec.design
    read = {
        step: [
            key
            for key, written in spec.arguments.items()
            if isinstance(written, str) and found & numbers(composition, written)
        ]
        for step, spec in steps.items()
    }
    return {step: arguments for step, arguments in read.items() if arguments}


def words(
    composition: Composition,
    values: Collection[str],
    kept: Collection[str] | None = None,
) -> list[str]:
    """Return a sentence for each design step that reads one of some values."""
    said = []
    for step, arguments in read_by(composition, values).items():
        written = composition.scenario.spec.design[step].arguments
        names = " and ".join(dict.fromkeys(str(written[a]) for a in arguments))
        said.append(
            f"design.{step} is told {names} as before, with which this was found; take "
            f"design.{step}.arguments out of the scenario written to design anew"
            if kept is None or step in kept
            else f"design.{step} is told {names} as found: it designs anew"
        )
    return said


def _told(
    composition: Composition, values: Collection[str], kept: Collection[str] | None
) -> dict[str, dict[str, dict[str, Any]]]:
    told: dict[str, dict[str, dict[str, Any]]] = {}
    for step, arguments in read_by(composition, values).items():
        if kept is None or step in kept:
            given = composition.designs[step].arguments
            told[step] = {"arguments": {a: _plain(given[a]) for a in arguments}}
    return told


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value
