"""The pages that scenarios and runs show in a notebook."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from orchestrator.errors import FeedDriveError
from orchestrator.master.simulate import plan
from orchestrator.pictures.timetable import timetable_picture
from orchestrator.pictures.wiring import wiring_picture
from orchestrator.report.page import write_report
from orchestrator.report.shell import written
from orchestrator.scenario.compose import compose

if TYPE_CHECKING:
    from orchestrator.outcome import Run
    from orchestrator.scenario.reading import Scenario


def write_scenario(scenario: "Scenario", path: Path) -> Path:
    """Write what a scenario composes, or why it does not, and return the path."""
    title = scenario.spec.title or scenario.name
    about = f"<p class=about>{escape(scenario.spec.description)}</p>"
    try:
        timetable = plan(compose(scenario, None).system)
        pictures: Mapping[str, str] = {
            "Wiring": wiring_picture(timetable),
            "Timetable": timetable_picture(timetable),
        }
    except (FeedDriveError, RuntimeError) as error:
        return written(title, [about, f"<p class=bad>{escape(str(error))}</p>"], path)
    shown = (
        f"<h2>{name}</h2><div class=picture>{picture}</div>"
        for name, picture in pictures.items()
    )
    return written(title, [about, *shown], path)


def write_run(run: "Run", path: Path) -> Path:
    """Write the report of a run and return the path."""
    return write_report([run], path)
