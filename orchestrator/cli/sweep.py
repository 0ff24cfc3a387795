"""The verb ``sweep``: does it still hold, at these rates, this delay, this mass?"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import (
    echo,
    error_console,
    executing,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Json, ScenarioName, Sets, Verbose

if TYPE_CHECKING:
    from orchestrator.analysis.sweep import Progress, Sweep
    from orchestrator.analysis.variations import Assignment, Axis
    from orchestrator.scenario.compose import Composition

SHOWN = 40  # members in the printed table


@executing
def sweep(
    scenario: ScenarioName,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="KEY=VALUES",
            help="plant.m_2=0.3e-3:0.5e-3:5, controller.latency=0,1,2, "
            "plant.m_2=+-20%:9; several make a grid",
        ),
    ] = [],  # noqa: B006 - Typer copies it
    sets: Sets = [],  # noqa: B006
    sample: Annotated[
        str | None,
        typer.Option(help="sobol, lhs or normal: draw from [tolerances]"),
    ] = None,
    n: Annotated[int, typer.Option("--n", help="members of a sample")] = 256,
    seed: Annotated[int, typer.Option(help="of a sample")] = 1,
    sensitivity: Annotated[
        int | None,
        typer.Option(
            metavar="N", help="Sobol's indices over [tolerances], N a power of two"
        ),
    ] = None,
    until_breaks: Annotated[
        str | None,
        typer.Option(
            "--until-breaks",
            metavar="KEY",
            help="how far may it go before an expectation fails?",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="of a Dask cluster, tcp://host:8786"),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="go on with the last one of this scenario")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="folder of the sweep")
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Run a scenario over varied values; show its figures and where it breaks."""
    from orchestrator.errors import ScenarioError

    set_up_logs(verbose)
    asked = [bool(vary), sample is not None, sensitivity is not None]
    asked.append(until_breaks is not None)
    if sum(asked) != 1:
        raise ScenarioError(
            "give one of --vary, --sample, --sensitivity and --until-breaks"
        )
    if until_breaks is not None:
        _until_breaks(scenario, until_breaks, sets, json)
    elif sensitivity is not None:
        _sensitivity(scenario, sets, sensitivity, seed, json)
    else:
        _sweep(scenario, sets, vary, sample, n, seed, scheduler, resume, output, json)


def _composed(scenario: str, sets: list[str]) -> "Composition":
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.reading import load_scenario
    from orchestrator.session import naming, run_earlier

    loaded = load_scenario(scenario, sets)
    with naming(loaded), waiting(f"building the FMUs of {loaded.name}"):
        return compose(loaded, run_earlier)


def _variations(
    composition: "Composition", vary: list[str], sample: Any, n: int, seed: int
) -> "Sequence[Axis] | Sequence[Assignment]":
    from orchestrator.analysis.tolerances import tolerances_of
    from orchestrator.analysis.variations import parse_axis
    from orchestrator.analysis.variations import sample as draw
    from orchestrator.errors import ScenarioError

    if vary:
        return [parse_axis(v, lambda k: composition.parameter(k).value) for v in vary]
    if sample not in ("sobol", "lhs", "normal"):
        raise ScenarioError(f"--sample {sample}: write sobol, lhs or normal")
    return draw(tolerances_of(composition), sample, n, seed)


def _sweep(
    scenario: str,
    sets: list[str],
    vary: list[str],
    sample: str | None,
    n: int,
    seed: int,
    scheduler: str | None,
    resume: bool,
    output: Path | None,
    json: bool,
) -> None:
    from orchestrator.analysis.cluster import Cluster
    from orchestrator.analysis.sweep import FIGURES, sweep
    from orchestrator.analysis.variations import Axis, grid
    from orchestrator.history.folder import Begun, taken
    from orchestrator.report.swept import write_swept

    composition = _composed(scenario, sets)
    name = composition.scenario.name
    variations = _variations(composition, vary, sample, n, seed)
    axes = [v for v in variations if isinstance(v, Axis)]
    total = sum(1 for _ in grid(axes)) if axes else len(variations)
    drawn = () if sample is None else (f"--sample {sample} --n {n} --seed {seed}",)
    changed = (*(f"--vary {v}" for v in vary), *drawn, *sets)
    earlier = _last(name) if resume else None
    cluster = Cluster(scheduler) if scheduler else None
    with taken(output, Begun("sweep", name, changed)) as place:
        with _progress(name, total) as progress:
            found = sweep(
                scenario,
                variations,
                sets=sets,
                folder=place.path,
                earlier=earlier,
                progress=progress,
                making=cluster,
            )
        spec = composition.scenario.spec
        words = _words(found, expects=bool(spec.expected_of_run))
        write_swept(
            name,
            found.keys,
            found.rows,
            found.units,
            spec.expected_of_run,
            words,
            place.path / "report.html",
        )
        told = {
            "scenario": name,
            "members": len(found.rows),
            "failed": found.failed,
            "wall_s": found.wall_s,
            "executor": "+".join(found.executors),
            "figures": str(place.path / FIGURES),
            "yield": found.met if spec.expected_of_run else None,
            "broken": found.broken(),
            "result": str(place.path),
        }
        place.complete(told)
    if cluster:
        cluster.close()
    if json:
        print_json(told)
    else:
        _print(found, words, scenario, sets)
        echo(f"figures: {place.path / FIGURES}\nreport: {place.path}/report.html")
    if found.failed:
        total = len(found.rows)
        echo(f"{found.failed} of {total} members failed", err=True)
        raise typer.Exit(1)


def _last(name: str) -> Path:
    """Return the folder of the last sweep of a scenario that did something."""
    from orchestrator.analysis.kept import MEMBERS
    from orchestrator.errors import ScenarioError
    from orchestrator.history import listing
    from orchestrator.history.folder import RUNS

    earlier = [
        e.folder
        for e in listing.entries(RUNS)
        if e.kind == "sweep"
        and e.name.rpartition("/")[0] == name
        and (e.folder / MEMBERS).is_file()
    ]
    if not earlier:
        raise ScenarioError(f"--resume: there is no sweep of {name} in {RUNS}/")
    return earlier[-1]


def _words(found: "Sweep", *, expects: bool) -> list[str]:
    words = [
        f"{len(found.rows)} members in {found.wall_s:.3g} s "
        f"({', '.join(found.executors) or 'all done before'})"
    ]
    if found.failed:
        first = next(row for row in found.rows if row["failure"])
        words.append(
            f"{found.failed} failed, the first is member {first['member']}: "
            f"{first['failure']}"
        )
    for figure, count in found.broken().items():
        words.append(f"{figure}: not met by {count} of {len(found.rows)}")
    held = f"yield {100 * found.met:.4g} %" if expects else "no yield without [expect]"
    return [*words, held]


def _print(
    found: "Sweep", words: Sequence[str], scenario: str, given: Sequence[str]
) -> None:
    names = [*found.keys, *found.units]
    head = ["member", *(f">{n}" for n in found.keys)]
    head += [f">{n} ({u})" for n, u in found.units.items()]
    rows = [
        [str(row["member"]), *(_cell(row.get(name)) for name in names)]
        for row in found.rows[:SHOWN]
    ]
    print_table(head, rows, found.scenario)
    if len(found.rows) > SHOWN:
        echo(f"... and {len(found.rows) - SHOWN} more members")
    for line in words:
        echo(line)
    worst = next((r for r in found.rows if r["broken"] or r["failure"]), None)
    if worst is not None:
        sets = [*given, *(f"{k}={worst[k]}" for k in found.keys)]
        command = " ".join([quote(scenario), *(f"--set {_quoted(s)}" for s in sets)])
        echo(f"member {worst['member']} in full: feeddrive run {command}")


def _quoted(text: str) -> str:
    """Return what is set as a shell reads it."""
    return quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


def _cell(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _until_breaks(scenario: str, key: str, sets: list[str], json: bool) -> None:
    from dataclasses import asdict

    from orchestrator.analysis.breaks import until_breaks

    with waiting(f"looking for where {scenario} breaks"):
        nominal, found = until_breaks(scenario, key, sets)
    if json:
        print_json({"key": key, "nominal": nominal, "breaks": [*map(asdict, found)]})
        return
    rows = [
        [
            b.direction,
            f"{b.holds:.6g}",
            f"{b.holds / nominal:.4g}",
            "" if b.breaks is None else f"{b.breaks:.6g}",
            b.what or "nothing breaks",
        ]
        for b in found
    ]
    head = ["direction", ">holds to", ">of nominal", ">breaks at", "what breaks"]
    print_table(head, rows, f"{key}, nominal {nominal:.6g}")


def _sensitivity(scenario: str, sets: list[str], n: int, seed: int, json: bool) -> None:
    from orchestrator.analysis.sweep import sweep
    from orchestrator.analysis.tolerances import sensitivities, tolerances_of

    tolerances = tolerances_of(_composed(scenario, sets))
    if not tolerances:
        from orchestrator.errors import ScenarioError

        raise ScenarioError("--sensitivity: the scenario has no [tolerances]")
    with waiting(f"{n * (2 + len(tolerances))} members of {scenario}"):
        found = sensitivities(
            tolerances, n, seed, lambda a: sweep(scenario, list(a), sets=sets).rows
        )
    keys = [t.key for t in tolerances]
    if json:
        told = {
            s.figure: {
                key: {"first": a, "total": b}
                for key, a, b in zip(keys, s.first, s.total, strict=True)
            }
            for s in found
        }
        print_json({"sensitivity": told, "members": n * (2 + len(tolerances))})
        return
    rows = [
        [s.figure, key, f"{a:.3f}", f"{b:.3f}"]
        for s in found
        for key, a, b in zip(keys, s.first, s.total, strict=True)
    ]
    print_table(["figure", "value", ">first order", ">total"], rows, scenario)


@contextmanager
def _progress(name: str, total: int) -> "Iterator[Progress]":
    """Show on a terminal's stderr how many members are done, the rate, what is left."""
    if not error_console().is_terminal:
        yield lambda done: None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=error_console(), transient=True) as bar:
        task = bar.add_task(name, total=total, rate="")

        def tell(done: int) -> None:
            speed = bar.tasks[0].speed or 0.0
            bar.update(task, completed=done, rate=f"{speed:.4g} members/s")

        yield tell
