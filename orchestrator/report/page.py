"""``report.html``: one page of a run or a comparison, with nothing to fetch.

Figures with their units, curves (Plotly, embedded), and what produced them:
components, rates, latencies, parameters set, design results, FMU digests, and
how the variables of foreign FMUs were mapped.
"""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.errors import ScenarioError
from orchestrator.evaluation.compare import change
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import ports
from orchestrator.master.faults import describe
from orchestrator.quantity import rate
from orchestrator.report.contour import contours
from orchestrator.report.figure import figure, name_of, names_of
from orchestrator.system import Component

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
    plot = figure(runs).to_html(
        full_html=False,
        include_plotlyjs=True,
        config=_CONFIG,
    )
    heading = title or name_of(runs[0])
    about = runs[0].scenario.spec.description if len(runs) == 1 else ""
    body = [
        f"<h1>{escape(heading)}</h1>",
        f"<p class=about>{escape(about)}</p>" if about else "",
        *(
            f"<p class=bad>{escape(f'{name}: ' if len(runs) > 1 else '')}"
            f"{escape(run.diverged)}</p>"
            for run, name in zip(runs, names_of(runs), strict=True)
            if run.diverged
        ),
        *(
            f"<p class=warning>{escape(f'{name}: ' if len(runs) > 1 else '')}"
            f"{escape(str(run.ended))}</p>"
            for run, name in zip(runs, names_of(runs), strict=True)
            if run.ended
        ),
        *(
            f"<p class=warning>{escape(f'{name}: ' if len(runs) > 1 else '')}"
            f"{escape(text)}</p>"
            for run, name in zip(runs, names_of(runs), strict=True)
            for text in run.warnings
        ),
        "<h2>Figures</h2>",
        _metrics(runs),
        "<h2>Signals</h2>",
        plot,
        *_contours(runs),
        *(
            _facts(run, f"{name} ({run.scenario.name})" if len(runs) > 1 else name)
            for run, name in zip(runs, names_of(runs), strict=True)
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
    return _table(head, rows)


def _checked(runs: "Sequence[Run]", name: str) -> str:
    found = [c for run in runs for c in run.checks if c.figure == name]
    marks = ("<b class=bad>&#10007;</b>", "<b class=good>&#10003;</b>")
    texts = (c.text.partition("expected ")[2] for c in found)
    return "<br>".join(
        f"{marks[c.met]} {escape(text)}" for c, text in zip(found, texts, strict=True)
    )


def _facts(run: "Run", label: str) -> str:
    system, composition = run.composition.system, run.composition
    rows = [
        [
            escape(c.name),
            f"<code>{escape(composition.sources[c.name])}</code>",
            c.kind or composition.fmus[c.name].kind or "continuous",
            rate(c.period) + (f", offset {c.offset} s" if c.offset else ""),
            f"{c.latency} sample{'s' * (c.latency != 1)}" if c.latency else "",
            "<br>".join(
                f"{escape(k)} = {escape(_short(v))}" for k, v in c.parameters.items()
            ),
            f"<code>{composition.digests[c.name][:12]}</code>",
        ]
        for c in system.components.values()
    ]
    head = ["component", "model", "kind", "step", "latency", "set", "SHA-256"]
    lines = [f"Simulated {system.stop} s (exactly)."]
    if run.timing is not None:
        lines.append(
            f"Took {run.timing.wall_s:.3g} s for {run.timing.instants:,} instants: "
            f"{run.timing.real_time_factor:.3g} times real time, "
            f"{run.timing.us_per_instant:.3g} us per instant."
        )
    if run.scenario.overrides:
        lines.append(f"Overrides: {', '.join(run.scenario.overrides)}.")
    for sink, faults in system.faults.items():
        lines.append(f"Faults of {sink}: {', '.join(map(describe, faults))}.")
    for name, found in composition.designs.items():
        values = ", ".join(f"{k} = {_short(v)}" for k, v in found.values.items())
        lines.append(f"Design {name} ({found.call}): {values}.")
    paragraphs = "".join(f"<p>{escape(line)}</p>" for line in lines)
    heading = f"<h2>How it was computed: {escape(label)}</h2>"
    maps = "".join(
        f"<h3>Map of {escape(c.name)} to {escape(composition.sources[c.name])}</h3>"
        f"{_map(c, composition.fmus[c.name])}"
        for c in system.components.values()
        if c.map
    )
    return f"{heading}{_table(head, rows)}{paragraphs}{maps}"


def _map(component: Component, fmu: FmuDescription) -> str:
    """Return what passes between our names and a foreign FMU's, each with its unit."""
    rows = []
    for ours in component.map:
        for port in ports(component, fmu, ours):
            theirs = port.variable
            inward = theirs.causality == "input"
            taken, given = (port.name, theirs.name)[:: 1 if inward else -1]
            row = [
                port.name,
                port.unit or "",
                theirs.causality,
                theirs.name,
                theirs.unit or "",
                f"{given} = {_affine(port.gain, taken, port.offset)}",
            ]
            rows.append([escape(cell) for cell in row])
    return _table(["ours", "unit", "is", "theirs", "unit", "what passes"], rows)


def _affine(gain: float, name: str, offset: float) -> str:
    """Return gain * name + offset as it is written by hand."""
    term = name if gain == 1 else f"-{name}" if gain == -1 else f"{gain:.9g} {name}"
    return f"{term} {'-' if offset < 0 else '+'} {abs(offset):.9g}" if offset else term


def _short(value: object) -> str:
    if isinstance(value, tuple):
        return f"{len(value)} numbers"
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    lines = ("".join(f"<td>{cell}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


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
.good { color: #2e8b57; } .bad { color: #d1495b; }
.warning { border-left: 3px solid #e09f3e; padding-left: 12px; max-width: 90ch; }
</style></head><body>
{body}
</body></html>
"""
