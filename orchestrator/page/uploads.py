"""An FMU file that is dropped onto the page: kept in the project once it is one."""

import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from fmus.cache import digest
from orchestrator.checks.engine import check_fmu
from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.page.project import Project

NAME = re.compile(r"[\w][\w .+-]{0,100}\.fmu", re.ASCII)
MOST = 20  # findings that are listed


def taken(project: Project, name: str, content: bytes) -> dict[str, Any]:
    """Keep a file in the project's folder; return what is to be said of it.

    Nothing of it is run: it is read, and its static items are checked.

    Raises:
        ScenarioError: no plain name of an FMU file, or another one has that name.
        FmuError: it is no FMU that can be read here.
    """
    if not NAME.fullmatch(name):
        raise ScenarioError(
            f"{name!r} cannot name a file here: letters, digits, spaces, . + - _ and "
            f".fmu at the end"
        )
    file = project.inside(name)
    partial = file.with_name(f".{name}.partial.fmu")
    partial.write_bytes(content)
    try:
        read_fmu(partial)
        if file.exists() and digest(file) != digest(partial):
            raise ScenarioError(
                f"{name}: another file of that name is here already; rename one of them"
            )
        partial.replace(file)
    except FeedDriveError as error:
        told = str(error).replace(str(partial), name)
        raise type(error)(told) from None
    finally:
        with suppress(FileNotFoundError):
            partial.unlink()
    return described(project, file)


def described(project: Project, file: Path) -> dict[str, Any]:
    """Return what an FMU file says of itself, and what checking it found."""
    found = read_fmu(file)
    report = check_fmu(file, dynamic=False)
    faults = [
        f"{outcome.item.title}: {finding.text}"
        for outcome in report.outcomes
        for finding in outcome.findings
    ]
    return {
        "file": file.relative_to(project.folder).as_posix(),
        "name": found.model_name,
        "about": found.description,
        "tool": found.tool,
        "fmi": found.fmi_major,
        "faults": faults[:MOST],
        "checked": len(report.outcomes),
        "ports": _ports(found),
    }


def _ports(fmu: FmuDescription) -> list[dict[str, Any]]:
    return [
        {
            "name": v.name,
            "causality": v.causality,
            "unit": str(v.unit or ""),
            "start": v.start,
            "about": v.description,
        }
        for v in fmu.variables.values()
        if v.causality in ("input", "output", "parameter")
    ]
