"""What the page asks for by HTTP, each answered with JSON."""

import json
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from orchestrator.errors import ScenarioError
from orchestrator.history.listing import Entry
from orchestrator.page.curves import finite
from orchestrator.page.project import Project
from orchestrator.page.shown import shown
from orchestrator.page.work import Work

Query: TypeAlias = Mapping[str, str]
View: TypeAlias = Callable[[Query, bytes], Any]


class Views:
    """The answers of a project's page; executed one at a time."""

    def __init__(self, project: Project, work: Work) -> None:
        self._project, self._work = project, work

    def all(self) -> dict[tuple[str, str], View]:
        """Return every view by method and name."""
        return {
            ("GET", "project"): self.project,
            ("GET", "scenario"): self.scenario,
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
        """A scenario composed: components, connections, parameters."""
        file = self._project.scenario(_named(query, "name"))
        kept = self._work.shelf.of(file)
        own = self._project.is_own(file)
        return finite(
            {
                "name": self._project.name_of(file),
                "own": own,
                "executor": kept.executor,
                **shown(kept.composition),
            }
        )


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
