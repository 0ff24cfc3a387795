"""The verb ``second-opinion``: the same system in other people's tools."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.output import (
    echo,
    executing,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Fmi, Json, Maps, ScenarioName, Sets, Swaps
from orchestrator.cli.running import load

if TYPE_CHECKING:
    from orchestrator.peers.second_opinion import SecondOpinion

Tools = Annotated[
    list[str],
    typer.Option(
        "--tool", metavar="NAME", help="only this tool (repeatable) [all there are]"
    ),
]


@executing
def second_opinion(
    scenario: ScenarioName,
    sets: Sets = [],  # noqa: B006 - Typer copies it
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    tool: Tools = [],  # noqa: B006
    install: Annotated[
        bool, typer.Option("--install", help="install tools that are missing")
    ] = False,
    fmi: Fmi = None,
    json: Json = False,
) -> None:
    """Run a scenario in other co-simulation tools too; print how far they differ."""
    from orchestrator.errors import ScenarioError, did_you_mean
    from orchestrator.peers import environment
    from orchestrator.peers import second_opinion as opinions

    set_up_logs(verbose=False)
    known = environment.every_peer()
    for name in tool:
        if name not in known:
            remedy = did_you_mean(name, known)
            raise ScenarioError(f"--tool {name}: there is no such tool; {remedy}")
    chosen = tuple(tool or known)
    loaded = load(scenario, sets, swap, map, fmi)
    if install:
        for name in chosen:
            try:
                with waiting(f"installing {name}"):
                    environment.install(known[name])
            except environment.PeerError as error:
                echo(str(error), err=True)
    with waiting(f"running {loaded.name} here and in {', '.join(chosen)}"):
        found = opinions.second_opinion(loaded, chosen)
    if json:
        print_json(asdict(found))
    else:
        print_opinion(found)
    for signal, tools in found.against.items():
        echo(f"{signal}: {', '.join(tools)} agree against this run", err=True)
    if found.against:
        raise typer.Exit(1)


def print_opinion(found: "SecondOpinion") -> None:
    """Print one row per signal, one column per tool, and what the tools changed."""
    answered = [peer for peer in found.peers if not peer.refusal]
    if answered:
        print_table(
            [
                "signal",
                "unit",
                ">largest",
                *(f">{peer.peer}" for peer in answered),
                ">as written",
            ],
            [
                [
                    first.signal,
                    "" if first.unit == "1" else first.unit,
                    f"{first.largest:.4g}",
                    *(
                        f"{one.difference:.2g}"
                        + (f" (label {one.label_offset:+d})" * bool(one.label_offset))
                        for one in (peer.signals[place] for peer in answered)
                    ),
                    f"{first.as_written:.2g}",
                ]
                for place, first in enumerate(answered[0].signals)
            ],
            f"{found.scenario} in steps of {found.step} s, {found.rows} rows here: "
            f"largest difference of each tool",
        )
    for peer in answered:
        offsets = {signal.label_offset for signal in peer.signals}
        labels = ", ".join(f"{offset:+d}" for offset in sorted(offsets))
        echo(
            f"{peer.peer} {peer.version}: {peer.rows} rows, time labels "
            f"{'as ours' if offsets == {0} else f'{labels} samples beside ours'}"
        )
    for peer in found.peers:
        if peer.refusal:
            echo(f"{peer.peer}: {peer.refusal}")
    if found.added:
        echo(
            f"these tools exchange after each step, so that {', '.join(found.added)} "
            f"act one sample later than the scenario says; the differences are to our "
            f"run with latency = 1 on them, 'as written' is to the scenario itself"
        )
