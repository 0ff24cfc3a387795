"""``report.html``: one page of a run or a comparison, with nothing to fetch.

What ran, its figures with their units, curves (Plotly, embedded, with every
recorded point), and how they were computed.
"""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.errors import ScenarioError
from orchestrator.evaluation.compare import change
from orchestrator.report.analysed import analysed
from orchestrator.report.composed import composed
from orchestrator.report.contour import contours
from orchestrator.report.facts import computed, table, what_ran
from orchestrator.report.figure import figure
from orchestrator.report.panels import name_of, names_of
from orchestrator.report.shell import shown, signals, written

if TYPE_CHECKING:
    from orchestrator.outcome import Run


@np.errstate(all="ignore")  # what diverges may overflow here
def write_report(runs: "Sequence[Run]", path: Path, title: str | None = None) -> Path:
    """Write the report of one run, or of several compared, and return its path.

    Raises:
        ScenarioError: there is no run to report.
    """
    if not runs:
        raise ScenarioError("a report needs at least one run")
    drawing = figure(runs)
    told = [f"{name}: " if len(runs) > 1 else "" for name in names_of(runs)]
    heading = title or name_of(runs[0])
    about = runs[0].scenario.spec.description if len(runs) == 1 else ""
    body = [
        f"<p class=about>{escape(about)}</p>" if about else "",
        *(
            f"<p class=bad>{escape(name + run.diverged)}</p>"
            for run, name in zip(runs, told, strict=True)
            if run.diverged
        ),
        *(
            f"<p class=warning>{escape(name + str(run.ended))}</p>"
            for run, name in zip(runs, told, strict=True)
            if run.ended
        ),
        *(
            f"<p class=warning>{escape(name + text)}</p>"
            for run, name in zip(runs, told, strict=True)
            for text in run.warnings
        ),
        *(
            what_ran(run, name.removesuffix(": "))
            for run, name in zip(runs, told, strict=True)
        ),
        "<h2>Figures</h2>",
        _metrics(runs),
        "<h2>Signals</h2>",
        signals(drawing),
        *_analysed(runs),
        *_contours(runs),
        *composed(runs),
        *(
            computed(
                run, f"{name}{run.scenario.name}" if len(runs) > 1 else name_of(run)
            )
            for run, name in zip(runs, told, strict=True)
        ),
    ]
    return written(heading, body, path)


def _analysed(runs: "Sequence[Run]") -> list[str]:
    plots = analysed(runs)
    return ["<h2>Errors and control signals</h2>", *plots] if plots else []


def _contours(runs: "Sequence[Run]") -> list[str]:
    plots = [shown(plot) for plot in contours(runs)]
    return ["<h2>Contours</h2>", *plots] if plots else []


def _metrics(runs: "Sequence[Run]") -> str:
    names = list(dict.fromkeys(name for run in runs for name in run.metrics))
    if not names:
        return "<p>The scenario defines no metrics.</p>"
    compared = len(runs) == 2
    head = ["figure", *names_of(runs)]
    head += ["change"] if compared else []
    head += ["expected"] if any(run.checks for run in runs) else []
    rows = []
    for name in names:
        values = [run.metrics.get(name) for run in runs]
        row = [escape(name), *(escape(str(v)) if v else "" for v in values)]
        if compared:
            row.append(escape(change(name, *(run.metrics for run in runs))))
        if "expected" in head:
            row.append(_checked(runs, name))
        rows.append(row)
    return table(head, rows)


def _checked(runs: "Sequence[Run]", name: str) -> str:
    found = [c for run in runs for c in run.checks if c.figure == name]
    marks = ("<b class=bad>&#10007;</b>", "<b class=good>&#10003;</b>")
    texts = (c.text.partition("expected ")[2] for c in found)
    return "<br>".join(
        f"{marks[c.met]} {escape(text)}" for c, text in zip(found, texts, strict=True)
    )
