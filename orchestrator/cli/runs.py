"""The verb ``runs``: what was run here, and taking it away."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import command, echo, print_json, print_table

if TYPE_CHECKING:
    from orchestrator.history.listing import Entry

SHOWN = 4  # figures of a run in its line


@command
def runs(
    scenario: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENARIO]", help="only its runs, or a study's [all in runs/]"
        ),
    ] = None,
    keep: Annotated[
        int | None,
        typer.Option(
            "--keep", metavar="N", min=0, help="remove all of these but the newest N"
        ),
    ] = None,
    remove: Annotated[
        list[str],
        typer.Option(
            "--remove",
            metavar="RUN",
            help="remove a run by its name or number (repeatable)",
        ),
    ] = [],  # noqa: B006 - Typer copies it
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """List the runs in runs/: what was changed, how far it got, what came out."""
    from orchestrator.errors import ScenarioError
    from orchestrator.history import listing
    from orchestrator.history.folder import RUNS

    if keep is not None and remove:
        raise ScenarioError("--keep and --remove: give one of the two")
    found = listing.entries(RUNS)
    if scenario is not None:
        found = [e for e in found if _within(e.name, scenario)]
    gone = [listing.find(name, found) for name in remove]
    if keep is not None:
        ended = [e for e in found if e.state != "under way"]
        gone = ended[: max(0, len(ended) - keep)]
    listing.remove(gone)
    left = [e for e in found if e not in gone]
    if json:
        removed = {"removed": [e.name for e in gone]} if gone else {}
        print_json({"runs": [e.as_json() for e in left], **removed})
        return
    for entry in gone:
        echo(f"removed {entry.folder}")
    if left:
        print_runs(left)
    elif not gone:
        echo(f"no runs{f' of {scenario}' if scenario else ''} in {RUNS}/")


def _within(name: str, scenario: str) -> bool:
    """Tell whether a run is one of a scenario, a study, or what ends like that."""
    is_file = scenario.endswith(".toml")
    folder = Path(scenario).stem if is_file else scenario.strip("/")
    return f"/{folder}/" in f"/{name}/"


def print_runs(found: "Sequence[Entry]") -> None:
    """Print one line per run, the newest last."""
    rows = [
        [
            entry.name,
            f"{entry.begun.astimezone():%Y-%m-%d %H:%M:%S}",
            _state(entry),
            ", ".join(entry.changed),
            entry.why.partition("\n")[0] or _figures(entry.summary),
        ]
        for entry in found
    ]
    print_table(["run", "begun", "state", "changed", "figures"], rows)


def _state(entry: "Entry") -> str:
    if entry.state == "complete":
        return entry.state
    if entry.reached is None:
        return entry.state if entry.kind != "run" else f"{entry.state}, no rows"
    of = "" if entry.stop is None else f" of {entry.stop:g}"
    return f"{entry.state} at {entry.reached:g}{of} s"


def _figures(told: Mapping[str, Any]) -> str:
    """Return the first figures of a run, the verdicts of a reproduction, the members
    of a sweep."""
    if "members" in told:
        met = told["yield"]
        share = [] if met is None else [f"yield {100 * met:.4g} %"]
        counted = f"{told['members']} members", f"{told['failed']} failed"
        return ", ".join([*counted, *share])
    if "figures" in told:
        counts: dict[str, int] = {}
        for figure in told["figures"]:
            counts[figure["verdict"]] = counts.get(figure["verdict"], 0) + 1
        return ", ".join(f"{n} {verdict}" for verdict, n in counts.items())
    if "runs" in told:
        return "; ".join(f"{r['scenario']}: {_figures(r)}" for r in told["runs"])
    metrics = told.get("metrics", {})
    shown = [f"{name} {_figure(m)}" for name, m in list(metrics.items())[:SHOWN]]
    more = len(metrics) - len(shown)
    words = [told["diverged"]] if told.get("diverged") else []
    return ", ".join([*words, *shown, *([f"{more} more"] if more else [])])


def _figure(metric: Mapping[str, Any]) -> str:
    if metric["value"] is None:
        return "none"
    unit = "" if metric["unit"] == "1" else f" {metric['unit']}"
    return f"{metric['value']:.5g}{unit}"
