"""The verb ``response``: what margin is left in a loop."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import (
    executing,
    print_json,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Fmi, Json, Maps, ScenarioName, Sets, Swaps, Verbose
from orchestrator.cli.running import load
from orchestrator.cli.swap import load_original

if TYPE_CHECKING:
    from orchestrator.response.expected import Responded


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
    excite: Annotated[
        list[str],
        typer.Option(
            metavar="COMPONENT.INPUT", help="instead: from where (repeatable)"
        ),
    ] = [],  # noqa: B006
    observe: Annotated[
        list[str],
        typer.Option(metavar="COMPONENT.OUTPUT", help="... to where (repeatable)"),
    ] = [],  # noqa: B006
    amplitude: Annotated[
        str, typer.Option(help='rms of what is injected, "0.1 V" [auto]')
    ] = "auto",
    lowest: Annotated[
        str, typer.Option("--from", metavar="HZ", help="lowest line, 0.5 or 0.5 Hz")
    ] = "1 Hz",
    excitation: Annotated[
        str, typer.Option(help="multisine, chirp or stepped (one sine at a time)")
    ] = "multisine",
    sets: Sets = [],  # noqa: B006
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    table: Annotated[
        Path | None,
        typer.Option(
            help="file for the lines, .csv or .parquet; of several responses one "
            "each, FILE_name.csv"
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="folder of the response")
    ] = None,
    fmi: Fmi = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Measure a closed loop's open loop, sensitivity and margins, or any transfer."""
    from orchestrator.cli.responded import print_response, write_page
    from orchestrator.history.folder import Begun, taken
    from orchestrator.response.expected import asking, respond
    from orchestrator.response.figures import as_json, write_table
    from orchestrator.response.traced import beside
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.responses import response_of
    from orchestrator.session import naming, run_earlier

    set_up_logs(verbose)
    loaded = load(scenario, sets, swap, map, fmi)
    one_asked = bool(broken or excite or observe)
    if one_asked:
        asked = response_of(broken, excite, observe, amplitude, lowest, excitation)
        loaded = asking(loaded, asked)
    before: Responded | None = None
    with naming(loaded), waiting(f"measuring {loaded.name}"):
        composition = compose(loaded, run_earlier)
        found = respond(composition)
        if swap:
            first = load_original(scenario, sets, swap, map, fmi)
            if one_asked:
                first = asking(first, asked)
            before = respond(compose(first, run_earlier))
        equations = {n: beside(composition, one) for n, one in found.responses.items()}
    changed = (
        *(f"--break {b}" for b in broken),
        *(f"--excite {e}" for e in excite),
        *(f"--observe {o}" for o in observe),
        *(f"--swap {s}" for s in swap),
        *sets,
    )
    told: dict[str, dict[str, Any]] = {}
    with taken(output, Begun("response", loaded.name, changed)) as place:
        for name, one in found.responses.items():
            stem = name if len(found.responses) > 1 else "response"
            file = _table(table, name, found) or place.path / f"{stem}.csv"
            traced, why = equations[name]
            told[name] = as_json(one, write_table(one, file, traced))
            told[name]["words"].append(why)
            page = place.path / f"{stem}.html"
            write_page(composition, name, one, before, equations[name], page)
        figures = {
            key: {"value": q.value, "unit": q.unit} for key, q in found.figures.items()
        }
        whole = told["loop"] if one_asked else {"responses": told, "figures": figures}
        place.complete({"scenario": loaded.name, "result": str(place.path), **whole})
    if json:
        print_json(whole)
    else:
        for name, one in found.responses.items():
            print_response(composition, name, one, found)
            typer.echo(equations[name][1])
            if before:
                for key in (f"{name}.s_max", f"{name}.peak"):
                    if key in before.figures:
                        typer.echo(f"{key} before the swap: {before.figures[key]}")
        typer.echo(f"report: {place.path}/{stem}.html")
    if failed := [c.text for c in found.checks if not c.met]:
        typer.echo("expectation not met: " + "; ".join(failed), err=True)
        raise typer.Exit(1)


def _table(asked: Path | None, name: str, found: "Responded") -> Path | None:
    """Return the file of one response's lines: of several each has its own."""
    if asked is None or len(found.responses) == 1:
        return asked
    return asked.with_stem(f"{asked.stem}_{name}")
