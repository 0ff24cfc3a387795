"""What can be changed of a scenario in the page; each a change of its file.

``do`` names one of ``EDITS``, which take the document and what the page says.
"""

import os.path
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from orchestrator.errors import ScenarioError, WiringError
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.ports import connection, ports
from orchestrator.page.document import Document, lines
from orchestrator.page.project import Project
from orchestrator.scenario.locate import component_of, locate
from orchestrator.scenario.reading import Scenario, load_scenario
from orchestrator.scenario.written import parse_setting
from orchestrator.system import Component, split_name

Said: TypeAlias = Mapping[str, Any]
Edit: TypeAlias = Callable[[Project, Document, Said], None]
TIMES = ("step", "offset", "latency", "kind")
NAME = re.compile(r"[A-Za-z_]\w*")


def found_parts(
    scenario: Scenario,
) -> tuple[dict[str, tuple[Component, FmuDescription]], dict[str, str]]:
    """Return the components of a scenario that can be had, and why others cannot."""
    found, whys = {}, {}
    for name, spec in scenario.spec.components.items():
        try:
            located = locate(scenario, scenario.spec, name, spec)
            found[name] = (
                component_of(name, spec, located),
                read_fmu(located.path),
            )
        except Exception as error:  # a BuildError, too; the page shows what is left
            whys[name] = str(error)
    return found, whys


def refuse_apart(scenario: Scenario, source: str, sink: str) -> None:
    """Refuse a connection of two variables that do not fit.

    Raises:
        WiringError: names, types or units do not fit; the message has the remedy.
    """
    found, whys = found_parts(scenario)
    ends = []
    for end in (source, sink):
        component, variable = split_name(end)
        if component in whys:
            raise WiringError(whys[component])
        if component not in found:
            raise WiringError(f"{end}: there is no component {component!r}")
        ends.append(ports(*found[component], variable))
    if len(ends[0]) != len(ends[1]):
        raise WiringError(
            f"{source} -> {sink}: {len(ends[0])} numbers cannot drive {len(ends[1])}"
        )
    for one, other in zip(*ends, strict=True):
        if other.variable.causality not in ("input", "parameter"):
            raise WiringError(f"{sink} is no input, but {other.variable.causality}")
        connection(one, other)


def connect(project: Project, document: Document, said: Said) -> None:
    """Let ``source`` (a variable, or a number) drive the input ``sink``."""
    source, sink = said["source"], _text(said, "sink")
    if isinstance(source, str):
        refuse_apart(load_scenario(document.file), source, sink)
    document.put(("connections", sink), source)


def disconnect(project: Project, document: Document, said: Said) -> None:
    """Let nothing drive the input ``sink``."""
    sink = _text(said, "sink")
    lines = document.merged.get("connections", {})
    if sink not in lines:
        stars = [f'"{key}"' for key in lines if "*" in key]
        raise ScenarioError(
            f"{sink} is driven by a line with a star, {' or '.join(stars)}; name its "
            f"inputs one by one in the text"
        )
    document.drop(("connections", sink))


def values(project: Project, document: Document, said: Said) -> None:
    """Write ``settings``, by component.variable, as the scenario's own values."""
    for name, value in dict(said["settings"]).items():
        component, variable = split_name(str(name))
        own = document.component(component)
        with suppress(ValueError):
            parse_setting(value)
        start = variable in own.get("start", {}) or variable.startswith("state.")
        table = "start" if start else "parameters"
        document.put(("components", component, table, variable), value)


def times(project: Project, document: Document, said: Said) -> None:
    """Set one of ``TIMES`` of component ``name``; no text is the default."""
    name, key, value = _text(said, "name"), _text(said, "key"), said["value"]
    document.component(name)
    if key not in TIMES:
        raise ScenarioError(f"{key} is none of {', '.join(TIMES)}")
    if value == "":
        document.drop(("components", name, key))
    else:
        document.put(("components", name, key), value)


def add(project: Project, document: Document, said: Said) -> None:
    """Add component ``name``, its ``fmu`` a model of ours or a file here."""
    name = _text(said, "name")
    if not NAME.fullmatch(name):
        raise ScenarioError(f"{name!r} is no name: letters, digits and _ only")
    if name in document.merged.get("components", {}):
        raise ScenarioError(f"there is a component {name!r} already")
    document.put(("components", name, "fmu"), fmu_beside(project, document, said))
    if said.get("step"):
        document.put(("components", name, "step"), _text(said, "step"))


def remove(project: Project, document: Document, said: Said) -> None:
    """Take component ``name`` away, with its connections and records."""
    name = _text(said, "name")
    document.component(name)
    for table in ("connections", "record", "faults"):
        entries = dict(document.merged.get(table, {}))
        for key, value in entries.items():
            if any(str(end).startswith(f"{name}.") for end in (key, value)):
                document.drop((table, key))
    document.drop(("components", name))


def replace(project: Project, document: Document, said: Said) -> None:
    """Put ``fmu`` in the place of component ``name``, with the lines of ``map``.

    Values of the scenario that the other FMU does not take are removed; what designs
    are told of its parameters stays as it was, as ``numbers``.  The page shows both
    before (``views.propose``).
    """
    name = _text(said, "name")
    document.component(name)
    document.put(("components", name, "fmu"), fmu_beside(project, document, said))
    if said.get("map", "").strip():
        document.put(("components", name, "map"), lines(_text(said, "map")))
    elif "map" in document.component(name):
        document.drop(("components", name, "map"))
    for variable in said.get("left", ()):
        own = str(variable).removeprefix(f"{name}.")
        for table in ("parameters", "start"):
            with suppress(ScenarioError):  # it stands in the other one
                document.drop(("components", name, table, own))
    for one in said.get("numbers", ()):
        argument = ("design", _text(one, "step"), "arguments", _text(one, "argument"))
        document.put(argument, float(one["value"]))


def remap(project: Project, document: Document, said: Said) -> None:
    """Set the map of component ``name`` to the lines of ``map``; none removes it."""
    name = _text(said, "name")
    document.component(name)
    if said["map"].strip():
        document.put(("components", name, "map"), lines(_text(said, "map")))
    else:
        document.drop(("components", name, "map"))


def record(project: Project, document: Document, said: Said) -> None:
    """Record ``signal`` at every step of its component, or no longer."""
    signal = _text(said, "signal")
    if said["on"]:
        document.put(("record", signal), True)
    else:
        document.drop(("record", signal))


def fmu_beside(project: Project, document: Document, said: Said) -> str:
    """Return how a scenario names an FMU: a file of the project from its own folder.

    Raises:
        ScenarioError: it lies outside, or is no file.
    """
    written = _text(said, "fmu")
    if not written.endswith((".fmu", ".py")):
        return written
    file = project.inside(written)
    if not file.is_file():
        raise ScenarioError(f"{written}: there is no such file in this project")
    return relative(file, document.file)


def relative(file: Path, beside: Path) -> str:
    """Return the path of a file from the folder of another."""
    return os.path.relpath(file, beside.resolve().parent).replace(os.sep, "/")


def _text(said: Said, key: str) -> str:
    found = said.get(key)
    if not isinstance(found, str) or not found:
        raise ScenarioError(f"{key} is missing")
    return found


EDITS: dict[str, Edit] = {
    "connect": connect,
    "disconnect": disconnect,
    "values": values,
    "times": times,
    "add": add,
    "remove": remove,
    "replace": replace,
    "remap": remap,
    "record": record,
}
