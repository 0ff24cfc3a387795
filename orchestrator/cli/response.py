"""The verb ``response``: what margin is left in a loop."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import (
    executing,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Fmi, Json, Maps, ScenarioName, Sets, Swaps, Verbose
from orchestrator.cli.running import load
from orchestrator.cli.swap import load_original

if TYPE_CHECKING:
    from orchestrator.response.expected import Responded
    from orchestrator.response.measure import Response
    from orchestrator.scenario.compose import Composition

LATENCY = ["samples more", ">phase margin (deg)", ">gain margin (dB)", ">s_max"]


@executing
def response(
    scenario: ScenarioName,
    broken: Annotated[
        list[str],
        typer.Option(
            "--break",
            metavar="COMPONENT.OUTPUT",
            help="where the loop is broken [all of the scenario's [responses]]; "
            "several together give singular values",
        ),
    ] = [],  # noqa: B006 - Typer copies it
    amplitude: Annotated[
        str, typer.Option(help='rms of what is injected, "0.1 V" [auto]')
    ] = "auto",
    lowest: Annotated[
        str, typer.Option("--from", metavar="HZ", help="lowest line, e.g. 0.5 Hz")
    ] = "1 Hz",
    excitation: Annotated[
        str, typer.Option(help="multisine, chirp or stepped (one sine at a time)")
    ] = "multisine",
    sets: Sets = [],  # noqa: B006
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    table: Annotated[
        Path | None, typer.Option(help="file for the lines, .csv or .parquet")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="folder of the response")
    ] = None,
    fmi: Fmi = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Measure the open loop, sensitivity and margins of a scenario's closed loop."""
    from orchestrator.history.folder import Begun, taken
    from orchestrator.response.expected import asking, respond
    from orchestrator.response.figures import as_json, write_table
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.responses import response_of
    from orchestrator.session import naming, run_earlier

    set_up_logs(verbose)
    loaded = load(scenario, sets, swap, map, fmi)
    if broken:
        asked = response_of(broken, amplitude, lowest, excitation)
        loaded = asking(loaded, asked)
    before: Responded | None = None
    with naming(loaded), waiting(f"measuring {loaded.name}"):
        composition = compose(loaded, run_earlier)
        found = respond(composition)
        if swap:
            first = load_original(scenario, sets, swap, map, fmi)
            if broken:
                first = asking(first, asked)
            before = respond(compose(first, run_earlier))
    changed = (*(f"--break {b}" for b in broken), *(f"--swap {s}" for s in swap), *sets)
    told: dict[str, dict[str, Any]] = {}
    with taken(output, Begun("response", loaded.name, changed)) as place:
        for name, one in found.responses.items():
            stem = name if len(found.responses) > 1 else "response"
            file = table or place.path / f"{stem}.csv"
            told[name] = as_json(one, write_table(one, file))
            _page(composition, name, one, before, place.path / f"{stem}.html")
        figures = {
            key: {"value": q.value, "unit": q.unit} for key, q in found.figures.items()
        }
        whole = told["loop"] if broken else {"responses": told, "figures": figures}
        place.complete({"scenario": loaded.name, "result": str(place.path), **whole})
    if json:
        print_json(whole)
    else:
        for name, one in found.responses.items():
            _print(f"{loaded.name}: {', '.join(one.breaks)}", name, one, found)
            if before:
                other = before.responses[name].s_max[0]
                typer.echo(f"s_max before the swap: {other:.5g}")
        typer.echo(f"report: {place.path}/{stem}.html")
    if failed := [c.text for c in found.checks if not c.met]:
        typer.echo("expectation not met: " + "; ".join(failed), err=True)
        raise typer.Exit(1)


def _print(title: str, name: str, one: "Response", found: "Responded") -> None:
    from orchestrator.response.figures import words

    rows = [
        [key.rpartition(".")[2], f"{q.value:.5g}", "" if q.unit == "1" else str(q.unit)]
        for key, q in found.figures.items()
        if key.rpartition(".")[0] == name
    ]
    print_table(["figure", ">value", "unit"], rows, title)
    print_table(["loop", "at (Hz)", ">margin"], list(_margin_rows(one)))
    if len(one.breaks) == 1:
        print_table(LATENCY, _latency_rows(one))
    for line in words(one):
        typer.echo(line)


def _margin_rows(one: "Response") -> Iterator[list[str]]:
    for name, loop in zip(one.breaks, one.loops, strict=True):
        for c in loop.crossovers:
            yield [name, f"{c.hz:.4g}", f"{c.phase_margin_deg:.4g} deg"]
        for g in loop.gain_margins:
            yield [name, f"{g.hz:.4g}", f"{g.db:.4g} dB"]


def _latency_rows(one: "Response") -> list[list[str]]:
    from orchestrator.response.figures import latencies

    return [
        [
            f"{row['samples']:+d}",
            f"{row['phase_margin_deg']:.4g}",
            f"{row['gain_margin_db']:.4g}",
            f"{row['s_max']:.4g}" if row["s_max"] < float("inf") else "unstable",
        ]
        for row in latencies(one)
    ]


def _page(
    composition: "Composition",
    name: str,
    one: "Response",
    before: "Responded | None",
    path: Path,
) -> None:
    from orchestrator.report.responded import write_responded
    from orchestrator.response.figures import curves, words

    drawn = curves(one, "after " if before else "")
    if before:
        drawn += curves(before.responses[name], "before ", other=True)
    tables: list[tuple[Sequence[str], Sequence[Sequence[str]]]] = [
        (["loop", "at (Hz)", "margin"], list(_margin_rows(one)))
    ]
    if len(one.breaks) == 1:
        tables.append(([h.removeprefix(">") for h in LATENCY], _latency_rows(one)))
    write_responded(
        f"{composition.scenario.name}: {', '.join(one.breaks)}",
        list(words(one)),
        tables,
        drawn,
        dict(_borders(composition, name)),
        path,
    )


def _borders(composition: "Composition", name: str) -> Iterator[tuple[str, float]]:
    expect = composition.scenario.spec.expect
    for figure, turned in ((f"{name}.s_max", False), (f"{name}.modulus_margin", True)):
        if figure in expect:
            e = expect[figure]
            for level in (e.above, e.below):
                if level:
                    yield f"{figure} {level:g}", 1 / level if turned else level
