"""What the page asks for by HTTP, each answered with JSON or a picture."""

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import tomlkit

from fmus.build import build
from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.fmu.description import read_fmu
from orchestrator.history.listing import Entry
from orchestrator.page.curves import finite
from orchestrator.page.document import lines
from orchestrator.page.edits import EDITS, NAME
from orchestrator.page.kept import Kept
from orchestrator.page.project import Project
from orchestrator.page.shown import halfway, shown
from orchestrator.page.uploads import described, taken
from orchestrator.page.work import Work, refusal
from orchestrator.pictures.timetable import timetable_picture
from orchestrator.pictures.wiring import wiring_picture
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.propose import lacking, proposal
from orchestrator.scenario.reading import load_scenario, read_scenario
from orchestrator.scenario.toml import read_toml_text

Query: TypeAlias = Mapping[str, str]
View: TypeAlias = Callable[[Query, bytes], Any]


class Views:
    """The answers of a project's page; executed one at a time.

    ``models`` are the names of ours.
    """

    def __init__(self, project: Project, work: Work, models: Iterable[str]) -> None:
        self._project, self._work, self._models = project, work, models

    def all(self) -> dict[tuple[str, str], View]:
        """Return every view by method and name."""
        return {
            ("GET", "project"): self.project,
            ("GET", "scenario"): self.scenario,
            ("GET", "wiring"): self.wiring,
            ("GET", "timetable"): self.timetable,
            ("GET", "parts"): self.parts,
            ("GET", "fmu"): self.fmu,
            ("GET", "text"): self.text,
            ("POST", "write"): self.write,
            ("POST", "edit"): self.edit,
            ("POST", "undo"): self.undo,
            ("POST", "own"): self.own,
            ("POST", "begin"): self.begin,
            ("POST", "upload"): self.upload,
            ("POST", "propose"): self.propose,
        }

    def project(self, query: Query, body: bytes) -> Any:
        """Scenarios, FMU files and kept runs."""
        return finite(
            {
                "folder": str(self._project.folder),
                "scenarios": self._project.scenarios(),
                "fmus": self._project.fmus(),
                "runs": [_run(entry) for entry in self._project.runs()],
            }
        )

    def scenario(self, query: Query, body: bytes) -> Any:
        """A scenario composed: components, connections, parameters.

        Of one that does not fit together what is there, and why it does not.
        """
        file = self._project.scenario(_named(query, "name"))
        own = self._project.is_own(file)
        head = {
            "name": self._project.name_of(file),
            "own": own,
            "undo": file in self._work.editor.files(),
        }
        try:
            kept = self._work.shelf.of(file)
        except Exception as error:
            scenario = load_scenario(file)
            return finite({**head, "error": refusal(error), **halfway(scenario)})
        told = shown(kept.composition)
        return finite({**head, "error": "", "executor": kept.executor, **told})

    def wiring(self, query: Query, body: bytes) -> str:
        """The wiring as a picture."""
        return wiring_picture(self._kept(query).timetable)

    def timetable(self, query: Query, body: bytes) -> str:
        """The timetable as a picture."""
        return timetable_picture(self._kept(query).timetable)

    def _kept(self, query: Query) -> Kept:
        return self._work.shelf.of(self._project.scenario(_named(query, "name")))

    def parts(self, query: Query, body: bytes) -> Any:
        """What a component can be: models of ours, FMU files of the project."""
        return {"models": list(self._models), "fmus": self._project.fmus()}

    def fmu(self, query: Query, body: bytes) -> Any:
        """What an FMU file of the project says of itself."""
        return described(self._project, self._project.inside(_named(query, "file")))

    def upload(self, query: Query, body: bytes) -> Any:
        """Keep an FMU file that was dropped."""
        return taken(self._project, _named(query, "name"), body)

    def text(self, query: Query, body: bytes) -> Any:
        """The file of a scenario as it is written."""
        file = self._project.scenario(_named(query, "name"))
        return {"text": read_toml_text(file)}

    def write(self, query: Query, body: bytes) -> Any:
        """Write a scenario's file whole."""
        said = given(body)
        file = self._owned(said)
        if str(said["before"]) != read_toml_text(file):
            raise ScenarioError(
                f"{file.name} was changed elsewhere meanwhile; open it again"
            )
        self._work.editor.write(file, str(said["text"]))
        return self._changed()

    def edit(self, query: Query, body: bytes) -> Any:
        """Change one thing of a scenario."""
        said = given(body)
        if said.get("do") not in EDITS:
            raise ScenarioError(f"there is no edit {said.get('do')!r}")
        with self._work.editor.changing(self._owned(said)) as document:
            EDITS[said["do"]](self._project, document, said)
        return self._changed()

    def undo(self, query: Query, body: bytes) -> Any:
        """Take the last change of a scenario back."""
        self._work.editor.undo(self._owned(given(body)))
        return self._changed()

    def own(self, query: Query, body: bytes) -> Any:
        """Copy a scenario, with all that it inherits, into the project."""
        said = given(body)
        tables = read_scenario(self._project.scenario(str(said["scenario"])))
        return self._new(said, tomlkit.dumps(tables))

    def begin(self, query: Query, body: bytes) -> Any:
        """Begin a scenario with one component."""
        said = given(body)
        name = str(said.get("component", ""))
        if not NAME.fullmatch(name):
            raise ScenarioError(f"{name!r} is no name: letters, digits and _ only")
        part = {"fmu": str(said.get("fmu", "")), "step": str(said.get("step", ""))}
        tables = {"stop": str(said.get("stop", "")), "components": {name: part}}
        return self._new(said, tomlkit.dumps(tables))

    def _new(self, said: Mapping[str, Any], text: str) -> Any:
        name = str(said["name"]).removesuffix(".toml")
        if not NAME.fullmatch(name):
            raise ScenarioError(f"{name!r} is no name: letters, digits and _ only")
        file = self._project.inside(f"{name}.toml")
        if file.exists():
            raise ScenarioError(f"{file.name} is there already; choose another name")
        self._work.editor.write(file, text)
        return {"name": self._project.name_of(file)}

    def propose(self, query: Query, body: bytes) -> Any:
        """What putting an FMU in a component's place would take: map, values left."""
        said = given(body)
        file = self._project.scenario(str(said["scenario"]))
        name, written = str(said["name"]), str(said["fmu"])
        kept = self._work.shelf.of(file).composition
        if name not in kept.system.components:
            raise ScenarioError(f"there is no component {name!r}")
        is_file = written.endswith(".fmu")
        place = self._project.inside(written) if is_file else None
        theirs = read_fmu(place or build(written))
        text = said.get("map")
        if text is None:
            if not lacking(kept.system, name, theirs):
                text = ""
            else:
                text = proposal(kept.system, name, kept.fmus[name], theirs)
        swap = {"fmu": str(place or written), "map": lines(text).unwrap()}
        left: list[dict[str, str]] = []
        why = ""
        try:
            swapped = Kept(file, swaps={name: swap})
            over = swapped.composition.not_taken_over
            left = [{"name": one.name, "text": str(one)} for one in over]
            swapped.close()
        except FeedDriveError as error:
            why = str(error)
        numbers = told_as_numbers(kept, name)
        return {"map": text, "left": left, "numbers": numbers, "error": why}

    def _owned(self, said: Mapping[str, Any]) -> Any:
        file = self._project.scenario(str(said.get("scenario", "")))
        if not self._project.is_own(file):
            raise ScenarioError(f"{said['scenario']} is published; copy it first")
        return file

    def _changed(self) -> Any:
        self._work.shelf.clear()
        return {}


def told_as_numbers(kept: Composition, name: str) -> list[dict[str, Any]]:
    """Return what designs are told of a component's parameters, as numbers.

    A design goes on being told the values of the component it was made for, as
    with ``--swap``: the other FMU may have them in other units, or not at all.
    """
    found = []
    for step, design in kept.scenario.spec.design.items():
        for argument, value in design.arguments.items():
            of, _, variable = str(value).partition(".")
            if of != name or not variable:
                continue
            quantity = kept.parameter(str(value))
            number = float(quantity.value)
            text = (
                f"design.{step} is told {argument} = {number:g} {quantity.unit}, as now"
            )
            found.append({"step": step, "argument": argument, "value": number})
            found[-1]["text"] = text
    return found


def _named(query: Query, key: str) -> str:
    if key not in query:
        raise ScenarioError(f"the request says no {key}")
    return query[key]


def given(body: bytes) -> dict[str, Any]:
    """Return the object of a request.

    Raises:
        ScenarioError: it is none.
    """
    try:
        found = json.loads(body)
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise ScenarioError("the request is no JSON object")
    return found


def _run(entry: Entry) -> dict[str, Any]:
    return {
        "name": entry.name,
        "kind": entry.kind,
        "state": entry.state,
        "begun": entry.begun.isoformat(),
        "changed": entry.changed,
        "why": entry.why,
        "report": (entry.folder / "report.html").is_file(),
        "metrics": entry.summary.get("metrics", {}),
    }
