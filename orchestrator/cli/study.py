"""Verbs on the published studies: ``demo``, ``reproduce``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.completion import study_names
from orchestrator.cli.output import (
    command,
    echo,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Json, Verbose
from orchestrator.cli.running import simulate
from orchestrator.evaluation.compare import number

if TYPE_CHECKING:
    from orchestrator.bands.spread import Band
    from orchestrator.outcome import Run
    from orchestrator.reproduction.reproduce import Reproduction

STUDY = "ball_screw_pole_placement"
COMPARED = ("p_pi_c_track_500", "mc_ppc_track_500")


@command
def demo(json: Json = False, verbose: Verbose = False) -> None:
    """Co-simulate a P-PI cascade and pole placement on one ball-screw drive."""
    from orchestrator.history.folder import Begun, taken
    from orchestrator.report.page import write_report
    from orchestrator.scenario.reading import load_scenario

    set_up_logs(verbose)
    title = "Ball-screw drive: pole placement against P-PI cascade"
    with taken(None, Begun("demo", "demo")) as place:
        runs = [
            simulate(load_scenario(f"{STUDY}/{name}"), place.path / name, report=False)
            for name in COMPARED
        ]
        page = write_report(runs, place.path / "report.html", title)
        told = {"runs": [done.summary() for done in runs], "report": str(page)}
        place.complete(told)
    if json:
        print_json(told)
        return
    print_comparison(runs, title)
    for done in runs:
        if done.timing is not None:
            echo(
                f"{done.scenario.name}: {done.timing.wall_s:.3g} s, "
                f"{done.timing.real_time_factor:.3g} x real time, "
                f"{done.timing.us_per_instant:.3g} us per instant"
            )
    echo(f"report with all curves: {page}")


def print_comparison(runs: "list[Run]", title: str) -> None:
    """Print the common figures of two runs, and how much lower the second's are."""
    from orchestrator.report.panels import names_of

    first, second = runs
    rows = []
    for name, before in first.metrics.items():
        after = second.metrics.get(name)
        if after is None or name.endswith(".mean"):  # a mean is not to be lowered
            continue
        after = after.to(before.unit)
        lower = 100 * (1 - after.value / before.value) if before.value else 0.0
        reduction = f"{lower:z.1f} %" if abs(lower) < 1000 else ""
        values = [number(q, digits=4) for q in (before, after)]
        rows.append([name, *values, before.unit, reduction])
    head = ["figure", *(f">{name}" for name in names_of(runs)), "unit", ">reduction"]
    print_table(head, rows, title)


@command
def scenarios(
    study: Annotated[
        str | None, typer.Argument(metavar="[STUDY]", help="only this study's")
    ] = None,
    json: Json = False,
) -> None:
    """List the scenarios there are, each by the name that run takes."""
    from orchestrator.scenario import reading

    folders = reading.studies() if study is None else [reading.find_study(study)]
    found = {
        reading.scenario_name(file): str(reading.read_scenario(file).get("title", ""))
        for folder in folders
        for file in reading.scenarios(folder).values()
    }
    if json:
        listed = [{"name": name, "title": title} for name, title in found.items()]
        print_json({"scenarios": listed})
    else:
        print_table(["scenario", "title"], list(map(list, found.items())))


@command
def reproduce(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY", help="e.g. " + STUDY, autocompletion=study_names
        ),
    ],
    only: Annotated[
        str, typer.Option(metavar="PATTERN", help="only figures like 'mc_ppc.*'")
    ] = "*",
    figures: Annotated[
        bool, typer.Option("--figures", help="make the page with the source's figures")
    ] = False,
    bands: Annotated[
        bool,
        typer.Option("--bands", help="sweep over what the source does not print"),
    ] = False,
    closed: Annotated[
        bool,
        typer.Option("--closed", help="only what a second edition closed, in a table"),
    ] = False,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Run a study's scenarios through FMUs and judge them by the published figures."""
    from orchestrator.cli.figures import print_reproduction
    from orchestrator.reproduction.reproduce import reproduce as reproduce_study

    set_up_logs(verbose)
    if closed:
        if only != "*" or figures or bands:
            raise typer.BadParameter("--closed prints its own table, of its own rows")
        _closed(study, json=json)
        return
    with waiting(f"reproducing {study}"):
        done = reproduce_study(
            study, only, told=lambda name: echo(f"ran {name}", err=True)
        )
    told = done.as_json(study)
    if figures:
        told["page"] = str(_page(study, done))
    spread = _bands(study) if bands else []
    if bands:
        told["bands"] = [band.as_json() for band in spread]
    if json:
        print_json(told)
    else:
        print_reproduction(study, done)
        if bands:
            _print_bands(spread)
        if figures:
            echo(f"figures and tables: {told['page']}")
    if failed := [f.spec.id for f in done.figures if f.regression == "FAILED"]:
        echo(f"acceptance missed: {', '.join(failed)}", err=True)
        raise typer.Exit(1)


def _closed(study: str, *, json: bool) -> None:
    from orchestrator.reproduction.closed import closed, read_closed, rows_of
    from orchestrator.reproduction.reproduce import reproduce as reproduce_study
    from orchestrator.scenario.reading import find_study

    found = []
    if differences := read_closed(find_study(study)):
        with waiting(f"reproducing {study}"):
            done = reproduce_study(
                study,
                rows_of(differences),
                told=lambda name: echo(f"ran {name}", err=True),
            )
        found = closed(differences, {figure.spec.id: figure for figure in done.figures})
    if json:
        print_json({"study": study, "closed": [one.as_json() for one in found]})
    elif not found:
        echo(f"{study}: no difference of a first edition was closed")
    else:
        rows = [list(one.as_json().values()) for one in found]
        head = ["difference", ">published", ">first edition", ">second edition"]
        title = f"{study}: what the second edition closed"
        print_table([*head, "unit", "free numbers"], rows, title)


def _page(study: str, done: "Reproduction") -> Path:
    from orchestrator.drawings.page import write_figures
    from orchestrator.drawings.registry import read_registry
    from orchestrator.scenario.reading import find_study

    registry = read_registry(find_study(study))
    file = done.folder / "figures.html"
    with waiting(f"drawing the figures of {study}"):
        return write_figures(
            registry, done, file, told=lambda number: echo(f"drew {number}", err=True)
        )


def _bands(study: str) -> "list[Band]":
    from orchestrator.bands.spread import bands
    from orchestrator.scenario.reading import find_study

    with waiting(f"sweeping over what the source of {study} does not print"):
        return bands(
            find_study(study), told=lambda name: echo(f"swept {name}", err=True)
        )


def _print_bands(bands: "list[Band]") -> None:
    if not bands:
        echo("no figure of the study rests on what its source does not print")
        return
    rows = [
        [
            band.row,
            band.where,
            band.published,
            f"{band.low:.4g}",
            f"{band.high:.4g}",
            band.unit,
            "inside" if band.inside else "outside",
            f"{band.members}" + f" ({band.failed} failed)" * bool(band.failed),
        ]
        for band in bands
    ]
    head = ["figure", "where", ">published", ">from", ">to", "unit", "is", "members"]
    print_table(head, rows, "bands over what the source does not print")
    for text in dict.fromkeys(line for band in bands for line in band.over):
        echo(f"  {text}")
