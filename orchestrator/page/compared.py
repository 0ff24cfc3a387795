"""Kept runs beside each other: what differs, figures, signals overlaid."""

from collections.abc import Sequence
from typing import Any

from orchestrator.errors import ScenarioError
from orchestrator.history.difference import differences, kept
from orchestrator.history.folder import RUNS
from orchestrator.page.project import Project
from orchestrator.quantities.quantity import NoValue
from orchestrator.report.overlaid import overlaid
from orchestrator.report.panels import Panel
from orchestrator.result import Result

MOST = 8  # runs at a time


def compared(
    project: Project, names: Sequence[str], signals: Sequence[str]
) -> tuple[dict[str, Any], list[Panel]]:
    """Return what is told of runs of a project, by name, and their panels.

    ``signals`` are those that are drawn, else those that all have.

    Raises:
        ScenarioError: there is no such run, or it was never begun.
    """
    if not 1 <= len(names) <= MOST:
        raise ScenarioError(f"tick one to {MOST} runs")
    found = [kept(f"{RUNS}/{project.run(name).name}") for name in names]
    results = {k.label: Result(k.folder) for k in found if k.folder is not None}
    panels, left = overlaid(results, signals) if results else ([], [])
    figures = dict.fromkeys(name for k in found for name in k.figures)
    told = {
        "runs": [k.label for k in found],
        "differences": [one._asdict() for one in differences(found)],
        "figures": [
            {
                "name": name,
                "values": [
                    None if isinstance(f, NoValue | None) else float(f.value)
                    for f in (k.figures.get(name) for k in found)
                ],
                "units": [
                    "" if (f := k.figures.get(name)) is None else str(f.unit)
                    for k in found
                ],
            }
            for name in figures
        ],
        "left": left,
    }
    return told, panels
