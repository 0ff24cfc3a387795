"""The verb ``run``: run a scenario, print its figures."""

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.completion import scenario_names
from orchestrator.cli.origin import origin_of
from orchestrator.cli.output import (
    echo,
    executing,
    print_json,
    print_table,
    set_up_logs,
)
from orchestrator.cli.rows import time
from orchestrator.cli.running import load, simulate
from orchestrator.cli.swap import (
    ORIGINAL,
    compare,
    load_original,
    print_swap,
    propose_map,
)
from orchestrator.evaluation.compare import number
from orchestrator.quantities.quantity import NoValue

if TYPE_CHECKING:
    from orchestrator.outcome import Run
    from orchestrator.profile import Profile


class Executor(StrEnum):
    """What carries out the steps; all give the same bits."""

    KERNEL = "kernel"
    PYTHON = "python"
    FUSED = "fused"


ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="<study>/<scenario>, a .toml file, or a package: .ssp, .ssd, folder",
        autocompletion=scenario_names,
    ),
]
Sets = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="component.parameter, component.step, rates.name, stop, "
        "design.step.argument, metrics.name.key, record.signal, connections.input ... "
        "(repeatable)",
    ),
]
Swaps = Annotated[
    list[str],
    typer.Option(
        "--swap",
        metavar="COMPONENT=FMU",
        help="put another FMU in the place of a component (repeatable)",
    ),
]
Maps = Annotated[
    list[str],
    typer.Option(
        "--map",
        metavar="TOML",
        help="names of the swapped FMU: a .toml file or inline "
        "'u = {name = \"voltage\", gain = -1}'; one per --swap, in order",
    ),
]
Sockets = Annotated[
    list[str],
    typer.Option(
        "--socket",
        metavar="NAME",
        help="objects of a drive before the swapped FMU: csp, csv, cst, telegram_105; "
        "one per --swap, in order",
    ),
]
Fmi = Annotated[
    int | None, typer.Option("--fmi", help="form in which our models are built: 2 or 3")
]
Variant = Annotated[
    str | None,
    typer.Option("--variant", metavar="NAME", help="another .ssd of a package (SSP)"),
]
Ssv = Annotated[
    list[str],
    typer.Option(
        "--ssv",
        metavar="FILE",
        help="parameter set for a whole package: a file, or one of its own (SSP)",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="show notes of the run")]


@executing
def run(
    scenario: ScenarioName,
    sets: Sets = [],  # noqa: B006 - Typer copies it
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    socket: Sockets = [],  # noqa: B006
    map_out: Annotated[
        Path | None,
        typer.Option(
            "--map-out", help="write the map that is proposed for a swap, run nothing"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="folder of the run [runs/<study>/<scenario>/<n>]"
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="lose the run that -o FOLDER holds")
    ] = False,
    fmi: Fmi = None,
    variant: Variant = None,
    ssv: Ssv = [],  # noqa: B006
    executor: Annotated[
        Executor | None,
        typer.Option(help="what carries out the steps [kernel where it can]"),
    ] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="say where the time went")
    ] = False,
    pace: Annotated[
        float | None,
        typer.Option(metavar="X", help="hold it to X times real time"),
    ] = None,
    checkpoint: Annotated[
        str | None,
        typer.Option(metavar="S", help="simulated time between points to resume from"),
    ] = None,
    keep_checkpoints: Annotated[
        bool, typer.Option("--keep-checkpoints", help="keep all of them, for --from")
    ] = False,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="RUN@S",
            help="begin with the state that a run kept of a simulated time",
        ),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Co-simulate a scenario; print its figures and write its folder."""
    from orchestrator.errors import ScenarioError

    set_up_logs(verbose)
    if overwrite and output is None:
        raise ScenarioError(
            "--overwrite: belongs to -o FOLDER; without it every run has a new folder"
        )
    apart = time(checkpoint, "--checkpoint")
    if apart is not None and swap:
        raise ScenarioError(
            "--checkpoint: a run with --swap is two runs, which cannot be resumed; "
            "name the other FMU in the scenario"
        )
    if keep_checkpoints and apart is None:
        raise ScenarioError("--keep-checkpoints: give --checkpoint S besides")
    origin = None if from_ is None else origin_of(from_)
    if map_out is not None:
        text = propose_map(scenario, sets, swap, fmi, map_out)
        if json:
            print_json({"map": text, "file": str(map_out)})
            return
        echo(
            f"{text}\nproposed and not applied: check every line, above all gains and "
            f"signs, and run again with --map {map_out}"
        )
        return
    original = load_original(scenario, sets, swap, map, fmi, socket) if swap else None
    loaded = load(scenario, sets, swap, map, fmi, variant, socket, ssv)
    options = {"executor": executor and executor.value, "profile": profile}
    beside: dict[str, Any] = {}

    def also(done: "Run") -> dict[str, Any]:
        """Run what a swap is compared with before the run is complete."""
        if original:
            first, answers = compare(original, done, swap, **options)
            beside.update(first=first, answers=answers)
        return told(done)

    def told(done: "Run") -> dict[str, Any]:
        """Return what JSON says of a swap besides."""
        if not beside:
            return {}
        return {
            ORIGINAL: beside["first"].summary()["metrics"],
            "answers": [asdict(one) for one in beside["answers"]],
            "warnings": list(done.warnings),
        }

    taking = {"overwrite": overwrite, "also": also, "checkpoint": apart}
    taking |= {"kept": keep_checkpoints, "origin": origin}
    done = simulate(loaded, output, pace=pace, **taking, **options)
    if json:
        print_json({**done.summary(), **told(done)})
    else:
        print_run(done)
        if beside:
            print_swap(beside["first"], done, beside["answers"])
    conclude(done, changed=bool(sets or swap or origin))


def conclude(done: "Run", *, changed: bool) -> None:
    """Say what is not as it should be, and end with 1 then.

    Figures of a scenario that was changed may well differ, but not be gone.
    """
    failed = [c.text for c in done.checks if not c.met and not (changed and c.decided)]
    if failed:
        echo("expectation not met: " + "; ".join(failed), err=True)
    if done.diverged:
        echo(done.diverged, err=True)
    for text in done.unlike:
        echo(text, err=True)
    if failed or done.diverged or (done.unlike and not changed):
        raise typer.Exit(1)


def print_run(done: "Run") -> None:
    """Print the figures of a run, its checks, its speed and its folder."""
    from orchestrator.master.undriven import in_words

    checks = {check.figure: check for check in done.checks}
    rows = []
    for name, figure in done.metrics.items():
        check = checks.get(name)
        mark = ("not as expected: ", "as expected: ")[check.met] if check else ""
        wanted = check.text.partition("expected ")[2] if check else ""
        why = figure.why if isinstance(figure, NoValue) else ""
        told = "; ".join(text for text in (why, mark + wanted) if text)
        unit = "" if figure.unit == "1" else figure.unit
        rows.append([name, number(figure), unit, told])
    title = done.scenario.spec.title or done.scenario.name
    if rows:
        print_table(["figure", ">value", "unit", "check"], rows, title)
    if done.ended:
        stop = float(done.composition.system.stop)
        echo(f"{done.ended} (the scenario stops at {stop:g} s)")
    if done.timing is not None:
        echo(
            f"{done.timing.simulated_s:g} s in {done.timing.wall_s:.3g} s, "
            f"{done.timing.real_time_factor:.3g} x real time, "
            f"{done.timing.us_per_instant:.3g} us per instant"
        )
    if done.timing is not None and done.timing.paced is not None:
        echo(str(done.timing.paced))
    if done.timing is not None and done.timing.profile is not None:
        print_profile(done.timing.profile)
    if held := in_words(done.composition.undriven):
        echo(held)
    echo(f"written to {done.folder}: report.html, metrics.json, result/")


def print_profile(profile: "Profile") -> None:
    """Print where the time of a run went."""
    spent = [(f"{n} (FMU)", s.seconds, s.steps) for n, s in profile.components.items()]
    spent.append(("master: exchange, checks, rows", profile.master_s, 0))
    spent.append(("files, progress, clock", profile.rest_s, 0))
    whole = sum(seconds for _, seconds, _ in spent)
    rows = [
        [
            name,
            f"{seconds:.3g}",
            f"{100 * seconds / whole:.1f}",
            f"{steps:,}" if steps else "",
            f"{1e6 * seconds / steps:.3g}" if steps else "",
        ]
        for name, seconds, steps in spent
    ]
    head = ["where", ">s", ">%", ">steps", ">us per step"]
    print_table(head, rows, "Where the time went")
    if profile.peak_bytes:
        echo(f"largest resident memory {profile.peak_bytes / 1e6:.0f} MB")
