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
from orchestrator.report.composed import composed
from orchestrator.report.contour import contours
from orchestrator.report.embedded import recorded
from orchestrator.report.facts import computed, table, what_ran
from orchestrator.report.figure import figure
from orchestrator.report.panels import name_of, names_of

if TYPE_CHECKING:
    from orchestrator.outcome import Run

_CONFIG = {"displaylogo": False, "responsive": True}


@np.errstate(all="ignore")  # what diverges may overflow here
def write_report(runs: "Sequence[Run]", path: Path, title: str | None = None) -> Path:
    """Write the report of one run, or of several compared, and return its path.

    Raises:
        ScenarioError: there is no run to report.
    """
    if not runs:
        raise ScenarioError("a report needs at least one run")
    drawing = figure(runs)
    plot = drawing.plot.to_html(
        full_html=False, include_plotlyjs=True, config=_CONFIG, div_id="signals"
    )
    told = [f"{name}: " if len(runs) > 1 else "" for name in names_of(runs)]
    heading = title or name_of(runs[0])
    about = runs[0].scenario.spec.description if len(runs) == 1 else ""
    body = [
        f"<h1>{escape(heading)}</h1>",
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
        plot,
        recorded(drawing.curves),
        *_contours(runs),
        *composed(runs),
        *(
            computed(
                run, f"{name}{run.scenario.name}" if len(runs) > 1 else name_of(run)
            )
            for run, name in zip(runs, told, strict=True)
        ),
    ]
    page = _PAGE.replace("{title}", escape(heading)).replace("{body}", "\n".join(body))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")
    return path


def _contours(runs: "Sequence[Run]") -> list[str]:
    plots = [
        plot.to_html(full_html=False, include_plotlyjs=False, config=_CONFIG)
        for plot in contours(runs)
    ]
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


_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body { font: 15px/1.5 system-ui, sans-serif; color: #22262b; margin: 0 auto;
  max-width: 1180px; padding: 24px 32px 64px; }
h1 { font-size: 26px; margin: 8px 0; }
h3 { font-size: 15px; margin: 20px 0 4px; }
h2 { font-size: 17px; margin: 32px 0 8px; border-bottom: 1px solid #d9dde3;
  padding-bottom: 4px; }
.about { color: #565d66; max-width: 75ch; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: 4px 20px 4px 0;
  border-bottom: 1px solid #eceff3; }
th { color: #565d66; font-weight: 600; }
code { font: 13px ui-monospace, monospace; }
.picture { overflow-x: auto; }
summary { cursor: pointer; color: #1f5fa8; }
.good { color: #2e8b57; } .bad { color: #d1495b; }
.warning { border-left: 3px solid #e09f3e; padding-left: 12px; max-width: 90ch; }
@page { margin: 14mm; }
@media print {
  body { font-size: 11px; max-width: none; padding: 0; }
  h1, h2, h3, summary { break-after: avoid; }
  tr, .plotly-graph-div, .picture { break-inside: avoid; }
  .picture svg { max-width: 100%; max-height: 250mm; }
  .modebar { display: none; }
}
</style></head><body>
{body}
<script>
addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach((d) => { d.open = true; });
  document.querySelectorAll(".js-plotly-plot").forEach((p) =>
    Plotly.relayout(p, { width: 680, autosize: false }));
});
addEventListener("afterprint", () =>
  document.querySelectorAll(".js-plotly-plot").forEach((p) =>
    Plotly.relayout(p, { width: null, autosize: true })));
</script>
</body></html>
"""
