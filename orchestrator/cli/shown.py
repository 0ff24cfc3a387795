"""Verbs that show a composition without running it: ``schedule``, ``wiring``."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import (
    echo,
    executing,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import (
    Fmi,
    Json,
    Maps,
    ScenarioName,
    Sets,
    Sockets,
    Swaps,
    Variant,
    Verbose,
)
from orchestrator.cli.running import load
from orchestrator.quantities.quantity import rate, time_text

if TYPE_CHECKING:
    from orchestrator.master.ages import Plan
    from orchestrator.master.timetable import Timetable

Picture = Annotated[
    Path | None,
    typer.Option("--picture", metavar="FILE.svg", help="draw it into this file too"),
]


@executing
def schedule(
    scenario: ScenarioName,
    sets: Sets = [],  # noqa: B006
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    socket: Sockets = [],  # noqa: B006
    fmi: Fmi = None,
    variant: Variant = None,
    picture: Picture = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Show who steps when and in which order, and every hold, delay and age."""
    from orchestrator.master.ages import explained
    from orchestrator.pictures.timetable import timetable_picture

    set_up_logs(verbose)
    timetable = _timetable(scenario, sets, swap, map, fmi, variant, socket)
    _draw(picture, timetable_picture, timetable)
    plan = explained(timetable)
    if json:
        print_json(_exact(asdict(plan)))
    else:
        print_plan(plan)


@executing
def wiring(
    scenario: ScenarioName,
    sets: Sets = [],  # noqa: B006
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    socket: Sockets = [],  # noqa: B006
    fmi: Fmi = None,
    variant: Variant = None,
    picture: Picture = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Show what is connected with what: units, gains, ages, what nothing drives."""
    from orchestrator.master.undriven import in_words, undriven
    from orchestrator.pictures.bundles import wires
    from orchestrator.pictures.wiring import wiring_picture

    set_up_logs(verbose)
    timetable = _timetable(scenario, sets, swap, map, fmi, variant, socket)
    _draw(picture, wiring_picture, timetable)
    found = list(wires(timetable))
    parts = timetable.wiring.parts
    free = undriven(timetable.wiring.system, {n: p.fmu for n, p in parts.items()})
    if json:
        told = {"wires": [w._asdict() for w in found]}
        print_json(_exact({**told, "undriven": [asdict(one) for one in free]}))
        return
    print_table(
        ["from", "to", "unit, gain, fault", ">youngest", ">oldest"],
        [
            [w.source, w.sink, w.conversion, _us(w.youngest), _us(w.oldest)]
            for w in found
        ],
        f"Connections of {timetable.wiring.system.name}, and how old values are",
    )
    if held := in_words(free):
        echo(held)


def _timetable(
    scenario: str,
    sets: list[str],
    swap: list[str],
    map: list[str],
    fmi: int | None,
    variant: str | None,
    socket: list[str],
) -> "Timetable":
    """Return the timetable of what the options of a verb describe; nothing runs."""
    from orchestrator.master.simulate import plan
    from orchestrator.scenario.compose import compose
    from orchestrator.session import naming

    loaded = load(scenario, sets, swap, map, fmi, variant, socket)
    with naming(loaded), waiting("building FMUs"):
        return plan(compose(loaded, None).system)


def _draw(
    file: Path | None, draw: "Callable[[Timetable], str]", of: "Timetable"
) -> None:
    """Write a picture where one is asked for.

    Raises:
        ScenarioError: the file is to be of another form than SVG.
    """
    from orchestrator.errors import ScenarioError

    if file is None:
        return
    if file.suffix != ".svg":
        raise ScenarioError(f"--picture {file}: pictures are SVG; name a .svg file")
    file.write_text(draw(of), encoding="utf-8")
    echo(f"written to {file}", err=True)


def print_plan(plan: "Plan") -> None:
    """Print the turns of the components and what happens to every signal."""
    from orchestrator.master.undriven import in_words

    echo(
        f"{plan.name}: {plan.stop} s in instants of {plan.tick} s, pattern repeats "
        f"every {plan.hyperperiod} s"
    )
    turns = [
        (t.component, t.kind, rate(t.period), t.offset, t.latency, f"{t.steps:,}")
        for t in plan.turns
    ]
    print_table(
        ["component", "kind", "step", "offset", "latency", ">steps"],
        [[str(cell) for cell in turn] for turn in turns],
        "Who steps when",
    )
    echo(f"order of the sampled components: {', '.join(plan.order) or 'none'}")
    print_table(
        ["source", "sink", "published", "read", ">youngest", ">oldest", "remark"],
        [
            [
                a.source,
                a.sink,
                rate(a.published),
                rate(a.read),
                _us(a.youngest),
                _us(a.oldest),
                a.remark,
            ]
            for a in plan.ages
        ],
        "Age of every signal when it is taken",
    )
    for note in plan.notes:
        echo(f"note: {note}")
    for warning in plan.warnings:
        echo(f"warning: {warning}")
    if held := in_words(plan.undriven):
        echo(held)


def _us(seconds: Fraction) -> str:
    return f"{float(seconds * 10**6):g} us"


def _exact(value: Any) -> Any:
    """Return a plan as JSON can hold it: fractions as exact text."""
    if isinstance(value, Mapping):
        return {key: _exact(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_exact(v) for v in value]
    return time_text(value) if isinstance(value, Fraction) else value
