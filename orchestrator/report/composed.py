"""The pictures of a report: how the runs are wired, and who steps when."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from orchestrator.master.simulate import plan
from orchestrator.pictures.timetable import timetable_picture
from orchestrator.pictures.wiring import wiring_picture
from orchestrator.report.panels import names_of

if TYPE_CHECKING:
    from orchestrator.outcome import Run


def composed(runs: "Sequence[Run]") -> list[str]:
    """Return wiring and timetable of the runs; one that several share is drawn once."""
    wired: dict[str, list[str]] = {}
    timed: dict[str, list[str]] = {}
    for run, name in zip(runs, names_of(runs), strict=True):
        timetable = plan(run.composition.system)
        try:
            wired.setdefault(wiring_picture(timetable), []).append(name)
        except RuntimeError as error:  # a picture less is no reason to lose a run
            told = f"<p class=warning>{escape(f'no picture: {error}')}</p>"
            wired.setdefault(told, []).append(name)
        timed.setdefault(timetable_picture(timetable), []).append(name)
    return [*_section("Wiring", wired, runs), *_section("Timetable", timed, runs)]


def _section(
    title: str, pictures: dict[str, list[str]], runs: "Sequence[Run]"
) -> list[str]:
    parts = [f"<h2>{title}</h2>"]
    for picture, names in pictures.items():
        if len(pictures) > 1 and len(runs) > 1:
            parts.append(f"<h3>{escape(', '.join(names))}</h3>")
        parts.append(f"<div class=picture>{picture}</div>")
    return parts
