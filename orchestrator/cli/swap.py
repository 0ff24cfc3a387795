"""What ``run --swap`` adds to a run: a proposal where names differ, and A against B.

The original runs in the subfolder ``original``; the report of the run overlays
both.  A map is never applied without having been given.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from orchestrator.cli.output import print_table, waiting
from orchestrator.cli.running import load, simulate
from orchestrator.evaluation.compare import change, number
from orchestrator.quantity import NoValue

if TYPE_CHECKING:
    from orchestrator.outcome import Run
    from orchestrator.scenario.compose import Composition
    from orchestrator.scenario.reading import Scenario

ORIGINAL = "original"
SWAPPED = "swapped"
OF_BOTH = ("step", "offset", "latency")


def load_original(
    name: str, sets: list[str], swaps: list[str], maps: list[str], fmi: int | None
) -> "Scenario":
    """Return the scenario without the swaps, with all else that is set on it.

    What is set on a swapped component holds for the original too, so that the two
    differ by the swap alone; what the original has not is left out, and named.

    Raises:
        ScenarioError: a foreign FMU has other names and there is no map; the
            message holds a proposal, as TOML.
    """
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.override import parse_swaps
    from orchestrator.session import naming, run_earlier

    tables = parse_swaps(swaps, maps)
    elsewhere = [text for text in sets if text.partition(".")[0].strip() not in tables]
    original = load(name, elsewhere, [], [], fmi)
    with naming(original), waiting("comparing names"):
        composition = compose(original, run_earlier)
        _refuse_other_names(composition, tables)
    kept = [text for text in sets if text in elsewhere or _shared(text, composition)]
    for text in sets:
        if text not in kept:
            typer.echo(f"original: without --set {text}, which it lacks", err=True)
    return load(name, kept, [], [], fmi)


def _shared(text: str, original: "Composition") -> bool:
    """Tell whether what is set on a swapped component exists in the original."""
    from orchestrator.scenario.propose import missing_names

    component, _, rest = text.partition("=")[0].strip().partition(".")
    if rest in OF_BOTH:
        return True
    name = rest.removeprefix("parameters.").removeprefix("start.")
    return not missing_names([name], original.fmus[component])


def _refuse_other_names(
    original: "Composition", swaps: Mapping[str, Mapping[str, Any]]
) -> None:
    from fmus.build import build
    from orchestrator.errors import ScenarioError
    from orchestrator.fmu.description import read_fmu
    from orchestrator.scenario.propose import (
        missing_names,
        propose,
        to_toml,
        used_names,
    )

    for component, swap in swaps.items():
        if "map" in swap:
            continue
        written = str(swap["fmu"])
        theirs = read_fmu(written if written.endswith(".fmu") else build(written))
        names = used_names(original.system, component)
        if not (missing := missing_names(names, theirs)):
            continue
        found = to_toml(propose(missing, original.fmus[component], theirs))
        raise ScenarioError(
            f"--swap {component}: {theirs.path.name} has no {', '.join(missing)}. "
            f"A map is proposed below and was not applied: check every line and the "
            f"signs, save it as map.toml and add --map map.toml\n\n{found}"
        )


def compare(
    original: "Scenario", swapped: "Run", swaps: list[str], **options: Any
) -> "Run":
    """Run the original too, overlay both in the report, and return its run."""
    from orchestrator.report.page import write_report

    first = simulate(original, swapped.folder / ORIGINAL, report=False, **options)
    names = ", ".join(f"{c} = {Path(f).name}" for c, _, f in _parts(swaps))
    title = swapped.scenario.spec.title or swapped.scenario.name
    with waiting("writing the report"):
        runs = [_titled(first, ORIGINAL), _titled(swapped, SWAPPED)]
        write_report(runs, swapped.folder / "report.html", f"{title}: {names}")
    return first


def _parts(swaps: Sequence[str]) -> list[tuple[str, str, str]]:
    return [text.partition("=") for text in swaps]


def _titled(run: "Run", title: str) -> "Run":
    from orchestrator.outcome import Run

    spec = run.scenario.spec.model_copy(update={"title": title})
    scenario = replace(run.scenario, spec=spec)
    composition = replace(run.composition, scenario=scenario)
    told = run.metrics, run.checks, run.diverged, run.warnings
    return Run(run, composition, *told)


def print_swap(first: "Run", second: "Run") -> None:
    """Print the figures of the original and of the swapped run side by side."""
    rows = []
    for name, before in first.metrics.items():
        after = second.metrics.get(name)
        if after is None:
            continue
        after = after.to(before.unit)
        difference = after.value - before.value
        rows.append(
            [
                name,
                number(before),
                number(after),
                "" if isnan(difference) else f"{difference:+.3g}",
                "" if before.unit == "1" else before.unit,
                change(name, first.metrics, second.metrics),
            ]
        )
    for left in second.composition.not_taken_over:
        row = [
            left.name,
            f"{left.value:.6g}",
            "not taken over",
            "",
            left.unit,
            left.why,
        ]
        rows.append(row)
    head = ["figure", f">{ORIGINAL}", f">{SWAPPED}", ">difference", "unit", ">change"]
    print_table(head, rows, "Original against swapped")
    if first.diverged:
        typer.echo(f"{ORIGINAL}: {first.diverged}")
    for run, name in ((first, ORIGINAL), (second, SWAPPED)):
        for figure, value in run.metrics.items():
            if isinstance(value, NoValue):
                typer.echo(f"{name}: {figure}: {value.why}")
