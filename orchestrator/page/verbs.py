"""Questions put to a scenario: a verb of the command line, started as it is.

It runs in a process of its own in the project's folder and keeps what it keeps there;
its log is shown while it goes on, its refusal where it was asked.
"""

import asyncio
import json
import signal
import sys
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any

from orchestrator.errors import FeedDriveError, Interrupted, ScenarioError, shown
from orchestrator.page.project import Project

ASKED: dict[str, tuple[str, ...]] = {  # options that take a text, or several
    "sweep": ("vary", "sample", "n", "until-breaks"),
    "response": ("break", "amplitude", "from"),
    "tune": ("free", "minimise", "subject-to", "over", "bounds", "generations"),
}
LONGEST = 400  # characters of a line of the log


class Asking:
    """A verb under way; ``aborted`` ends it as Ctrl-C does."""

    def __init__(self, project: Project, said: Mapping[str, Any]) -> None:
        verb = str(said.get("verb"))
        if verb not in ASKED:
            raise ScenarioError(f"{verb!r} is none of {', '.join(ASKED)}")
        file = project.scenario(str(said["scenario"]))
        self._project, self._folder, self._verb = project, project.folder, verb
        self._known = {entry.name for entry in project.runs()}
        self._command = [sys.executable, "-m", "orchestrator", verb, "--json"]
        for key, value in dict(said.get("options", {})).items():
            if key not in ASKED[verb]:
                raise ScenarioError(f"{verb} has no option {key!r} here")
            for one in value if isinstance(value, list) else [value]:
                self._command.append(f"--{key}={one}")
        self._command += ["--", project.name_of(file)]
        self._process: asyncio.subprocess.Process | None = None
        self._aborted = False

    def abort(self) -> None:
        """End it; what it has kept stays."""
        self._aborted = True
        if self._process and self._process.returncode is None:
            self._process.send_signal(signal.SIGINT)

    async def done(self, told: Callable[[str], Awaitable[None]]) -> dict[str, Any]:
        """Return what the verb prints as JSON, and the pages that it wrote.

        Raises:
            FeedDriveError: it was refused, failed, or was aborted.
        """
        pipe = asyncio.subprocess.PIPE
        self._process = process = await asyncio.create_subprocess_exec(
            *self._command, cwd=self._folder, stdout=pipe, stderr=pipe
        )
        assert process.stdout
        assert process.stderr
        printed = asyncio.create_task(process.stdout.read())
        try:
            last = ""
            while line := await process.stderr.readline():
                last = shown(line.decode(errors="replace").strip())[:LONGEST]
                await told(last)
            text = await printed
            await process.wait()
        finally:
            self.abort() if process.returncode is None else None
        try:
            answer: dict[str, Any] = json.loads(text)
        except ValueError:
            answer = {"error": last or "the verb printed nothing"}
        if "error" in answer:
            kind = Interrupted if self._aborted else FeedDriveError
            raise kind(str(answer["error"]))
        kept = [
            e.folder
            for e in self._project.runs()
            if e.name not in self._known and e.kind == self._verb
        ]
        return {"told": answer, **self._written(answer, kept[:1])}

    def _written(self, answer: Mapping[str, Any], kept: list[Path]) -> dict[str, Any]:
        """Return the folder that was kept and the pages that were written, by their
        paths below the project's."""
        found = [page for folder in kept for page in sorted(folder.glob("*.html"))]
        if str(answer.get("scenario", "")).endswith(".toml"):
            page = (self._folder / str(answer["scenario"])).with_suffix(".html")
            found += [page] * page.is_file()
        paths = [
            path.resolve().relative_to(self._folder).as_posix()
            for path in (*kept, *found)
            if path.resolve().is_relative_to(self._folder)
        ]
        return {"kept": paths[: len(kept)], "pages": paths[len(kept) :]}
