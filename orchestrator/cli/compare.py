"""Verbs on kept runs: ``compare``, what they differ in, and ``plot``, their signals."""

import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.completion import run_names
from orchestrator.cli.output import command, echo, print_json, print_table

if TYPE_CHECKING:
    from orchestrator.history.difference import Difference, Kept

PAGE = "compare.html"
LONGEST = 40  # letters of a value in the terminal


@command
def compare(
    runs: Annotated[
        list[str],
        typer.Argument(
            metavar="RUN RUN...",
            help="names that `runs` lists, folders, lock files; the first is compared "
            "with",
            autocompletion=run_names,
        ),
    ],
    signal: Annotated[
        list[str],
        typer.Option("--signal", help="draw this one (repeatable) [what two have]"),
    ] = [],  # noqa: B006 - Typer copies it
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE.html", help=f"the page [runs/{PAGE}]"
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Show in what runs differ, their figures side by side, their signals overlaid."""
    from orchestrator.errors import ScenarioError
    from orchestrator.history.difference import differences, kept
    from orchestrator.history.folder import RUNS
    from orchestrator.report.overlaid import write_overlaid
    from orchestrator.result import Result

    if len(runs) < 2:
        raise ScenarioError("compare: name two runs or more")
    if len(set(runs)) < len(runs):
        raise ScenarioError("compare: a run is named twice")
    found = [kept(name) for name in runs]
    apart = differences(found)
    results = {k.label: Result(k.folder) for k in found if k.folder is not None}
    labels = [k.label for k in found]
    heads = {
        "What differs": ["part", "key", *labels],
        "Figures": ["figure", *labels, *(["change"] if len(found) == 2 else [])],
    }
    rows = {"What differs": _told(apart), "Figures": _figures(found)}
    page = None
    if len(results) > 1:
        tables = [(name, heads[name], rows[name]) for name in heads]
        title = f"{' and '.join(labels)} compared"
        page = write_overlaid(title, results, tables, output or RUNS / PAGE, signal)
    if json:
        print_json(
            {
                "runs": labels,
                "differences": [one._asdict() for one in apart],
                "figures": {k.label: _plain(k) for k in found},
                "page": page and str(page),
            }
        )
        return
    if not apart:
        echo("the locks are equal: same scenario, FMUs and versions")
    for name, head in heads.items():
        if rows[name]:
            print_table(head, [[_short(c) for c in row] for row in rows[name]], name)
    if page:
        echo(f"signals and differences: {page}")


def _told(apart: "Sequence[Difference]") -> list[list[str]]:
    return [[one.part, one.key, *one.values] for one in apart]


def _figures(found: "Sequence[Kept]") -> list[list[str]]:
    from orchestrator.evaluation.compare import change

    names = dict.fromkeys(name for k in found for name in k.figures)
    rows = []
    for name in names:
        values = [k.figures.get(name) for k in found]
        row = [name, *("" if value is None else str(value) for value in values)]
        if len(found) == 2:
            row.append(change(name, found[0].figures, found[1].figures))
        rows.append(row)
    return rows


def _plain(one: "Kept") -> dict[str, dict[str, object]]:
    return {
        name: {"value": figure.value, "unit": str(figure.unit)}
        for name, figure in one.figures.items()
    }


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


@command
def plot(
    run: Annotated[
        str,
        typer.Argument(
            metavar="RUN",
            help="a name that `runs` lists, or a folder",
            autocompletion=run_names,
        ),
    ],
    signals: Annotated[
        list[str],
        typer.Argument(metavar="SIGNAL...", help="plant.x_2 controller.u"),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE.html",
            help="write this and open no browser [RUN/plot.html, opened]",
        ),
    ] = None,
) -> None:
    """Draw signals of a run over time: every recorded point shows when zoomed."""
    from orchestrator.errors import ScenarioError
    from orchestrator.history.difference import kept
    from orchestrator.report.overlaid import write_plotted
    from orchestrator.result import Result

    found = kept(run)
    if found.folder is None:
        raise ScenarioError(f"{run}: has no rows to plot")
    if output is not None and output.suffix not in (".html", ".htm"):
        raise ScenarioError(
            f"-o {output}: pages are HTML; name a .html file, whose camera saves a PNG"
        )
    target = output or found.folder / "plot.html"
    page = write_plotted(found.label, Result(found.folder), signals, target)
    if output is None and not webbrowser.open(page.resolve().as_uri()):
        echo("no browser could be opened", err=True)
    echo(f"written to {page}")
