"""The folder that the page works on: its scenarios, runs and FMU files.

Whatever a request names is looked up here; what does not lie inside the folder, links
resolved, is not there.  Published scenarios are listed beside, for reading only.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.history.folder import RUNS
from orchestrator.history.listing import Entry, entries, find
from orchestrator.scenario import reading

Stamp: TypeAlias = tuple[tuple[str, int, int], ...]
SKIPPED = {"runs", "dist", "node_modules", "__pycache__"}
WATCHED = (".toml", ".fmu", ".py", ".csv")
MOST = 2000  # files that are looked at


@dataclass(frozen=True)
class Project:
    """A project's folder, resolved."""

    folder: Path

    def inside(self, name: str) -> Path:
        """Return the file of a name below the folder.

        Raises:
            ScenarioError: it lies outside, or is no plain path.
        """
        if "\0" in name or "\\" in name:
            raise ScenarioError(f"{name!r} is no path of this project")
        path = (self.folder / name).resolve()
        if not path.is_relative_to(self.folder):
            raise ScenarioError(f"{name}: lies outside of the project {self.folder}")
        return path

    def scenario(self, name: str) -> Path:
        """Return the file of a scenario: of the project, or a published one.

        Raises:
            ScenarioError: there is none of that name.
        """
        if not name.endswith(".toml"):
            return reading.find_scenario(name)
        return reading.find_scenario(self.inside(name))

    def is_own(self, file: Path) -> bool:
        """Tell whether a scenario may be changed: a published one may not."""
        return file.resolve().is_relative_to(self.folder)

    def name_of(self, file: Path) -> str:
        """Return how the page names a scenario's file."""
        if self.is_own(file):
            return file.resolve().relative_to(self.folder).as_posix()
        return reading.scenario_name(file)

    def scenarios(self) -> list[dict[str, Any]]:
        """Return the project's own scenarios, then the published ones."""
        own = (f for f in self._files() if f.suffix == ".toml")
        found = [_listed(self.name_of(f), f, own=True) for f in own]
        published = (
            _listed(reading.scenario_name(f), f, own=False)
            for study in reading.studies()
            for f in reading.scenarios(study).values()
        )
        return [one for one in (*found, *published) if one]

    def fmus(self) -> list[str]:
        """Return the FMU files there are, by their path below the folder."""
        files = (f for f in self._files() if f.suffix == ".fmu")
        return [f.relative_to(self.folder).as_posix() for f in files]

    def runs(self) -> list[Entry]:
        """Return the kept runs, the newest first."""
        return entries(self.folder / RUNS)[::-1]

    def run(self, name: str) -> Entry:
        """Return a kept run.

        Raises:
            ScenarioError: there is none of that name.
        """
        self.inside(f"{RUNS}/{name}")
        return find(name, self.runs())

    def stamp(self) -> Stamp:
        """Return what changes when a file that may matter changes."""
        found = []
        for file in self._files():
            try:
                stat = file.stat()
            except OSError:  # gone since
                continue
            found.append((str(file), stat.st_mtime_ns, stat.st_size))
        return tuple(found)

    def _files(self) -> Iterator[Path]:
        """Yield files that may matter, in order; no hidden ones, no links out."""
        seen = 0
        for place, folders, names in os.walk(self.folder):
            folders[:] = sorted(
                f for f in folders if not f.startswith(".") and f not in SKIPPED
            )
            for name in sorted(names):
                seen += 1
                file = Path(place, name)
                if seen > MOST:
                    return
                if name.endswith(WATCHED) and file.resolve().is_relative_to(
                    self.folder
                ):
                    yield file


def _listed(name: str, file: Path, *, own: bool) -> dict[str, Any] | None:
    """Return what is listed of a scenario; None if the file is another TOML."""
    if file.name.startswith("_") or file.name.endswith(".lock.toml"):
        return None
    told = {"name": name, "title": "", "own": own, "error": ""}
    try:
        raw = reading.read_toml(file)
        if not {"components", "base"} & raw.keys():
            return None
        told["title"] = str(raw.get("title", ""))
    except FeedDriveError as error:
        told["error"] = str(error)
    return told
