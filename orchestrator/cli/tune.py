"""The verb ``tune``: gains that make a figure small and keep margins."""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.fit import bracket
from orchestrator.cli.output import (
    executing,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Json, ScenarioName, Verbose

if TYPE_CHECKING:
    from orchestrator.analysis.tune import Tuned
    from orchestrator.analysis.variations import Setting
    from orchestrator.scenario.compose import Composition

HEAD = ["value", ">before", ">tuned", ">bracket from", ">to", "unit"]
FIGURES = ["figure", ">before", ">tuned"]


@executing
def tune(
    scenario: ScenarioName,
    free: Annotated[
        str, typer.Option(metavar="NAMES", help="controller.K_*,controller.K_px")
    ],
    minimise: Annotated[
        str, typer.Option(metavar="FIGURE", help="of a metric, tracking.peak")
    ],
    subject_to: Annotated[
        list[str],
        typer.Option(
            "--subject-to",
            metavar="BOUND",
            help='"loop.modulus_margin >= 0.5", or a metric\'s (repeatable)',
        ),
    ] = [],  # noqa: B006 - Typer copies it
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="worst case over plant.m_2=+-20% (three values) or as sweep --vary",
        ),
    ] = [],  # noqa: B006
    bounds: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=LOW:HIGH",
            help="[a tenth to ten times the start value] (repeatable)",
        ),
    ] = [],  # noqa: B006
    seed: Annotated[int, typer.Option(help="of the search")] = 1,
    generations: Annotated[int, typer.Option(help="at most")] = 40,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="scenario with the values found"),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Tune parameters; write the scenario that has them and a page before/after."""
    from orchestrator.analysis import tune as tuning
    from orchestrator.analysis.begin import begin_of, free_of
    from orchestrator.analysis.candidates import parse_constraint
    from orchestrator.analysis.heir import words
    from orchestrator.analysis.variations import parse_axis
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.reading import load_scenario
    from orchestrator.session import naming, run_earlier

    set_up_logs(verbose)
    loaded = load_scenario(scenario)
    target = output or Path(f"{loaded.file.stem}_tuned.toml")

    def recompose(values: "Mapping[str, Setting]") -> "Composition":
        sets = [f"{name}={value}" for name, value in values.items()]
        return compose(load_scenario(loaded.file, sets), run_earlier)

    with naming(loaded), waiting(f"tuning {loaded.name}"):
        composition = compose(loaded, run_earlier)
        names = [name.strip() for name in free.split(",") if name.strip()]
        begin = begin_of(composition)
        wanted = free_of(composition, names, dict(map(bracket, bounds)), begin)
        found = tuning.tune(
            composition,
            wanted,
            minimise,
            [parse_constraint(text) for text in subject_to],
            [
                parse_axis(
                    f"{text}:3" if text.rstrip().endswith("%") else text,
                    lambda key: composition.parameter(key).value,
                )
                for text in over
            ],
            begin=begin,
            seed=seed,
            generations=generations,
            recompose=recompose,
            progress=_Keeping(composition, wanted, target),
        )
    tuning.scenario_of(composition, found, target)
    page = _page(composition, found, minimise, target)
    if json:
        print_json(
            {
                "best": found.best(),
                "objective": found.found.objective,
                "worst_case": dict(found.found.worst),
                "scenario": str(target),
                "start": begin,
                "before": found.start.objective,
                "margins": {k: list(v) for k, v in found.margins.items()},
                "evaluations": found.evaluations,
            }
        )
        return
    print_table(HEAD, _values(found), f"{loaded.name} tuned")
    print_table(FIGURES, _figures(found, minimise))
    for line in (*_begun(found, begin), *words(composition, found.best())):
        typer.echo(line)
    typer.echo(f"{found.evaluations} runs\nscenario: {target}\nreport: {page}")


class _Keeping:
    """Says how the search goes, and keeps its best so far as a scenario."""

    def __init__(
        self, composition: "Composition", free: Sequence[Any], target: Path
    ) -> None:
        self._composition, self._free, self._target = composition, free, target
        self._rank = float("inf")

    def __call__(self, generation: int, x: Any, judged: Any) -> None:
        from orchestrator.analysis.heir import write_heir

        sound = not judged.missed and isfinite(judged.objective)
        if judged.rank < self._rank and sound:
            self._rank = judged.rank
            best = {f.name: float(v) for f, v in zip(self._free, x, strict=True)}
            title = f"{self._composition.scenario.name} tuned, generation {generation}"
            write_heir(self._composition, best, title, self._target)
        told = f"{judged.objective:.6g}" if sound else "keeps no bound yet"
        typer.echo(f"generation {generation}: {told}", err=True)


def _begun(found: "Tuned", begin: Mapping[str, float]) -> Iterator[str]:
    free = {f.name for f in found.free}
    if told := [f"{n} = {v:.5g}" for n, v in begin.items() if n in free]:
        yield f"begun with tune.start: {', '.join(told)}"
    if told := [n for n in begin if n not in free]:
        yield f"of tune.start not free, so not used: {', '.join(told)}"


def _values(found: "Tuned") -> list[list[str]]:
    return [
        [
            free.name,
            f"{free.start:.6g}",
            f"{value:.6g}",
            f"{free.bracket[0]:.4g}",
            f"{free.bracket[1]:.4g}",
            free.unit,
        ]
        for free, value in zip(found.free, found.values, strict=True)
    ]


def _figures(found: "Tuned", objective: str) -> list[list[str]]:
    worst = ", ".join(f"{k} = {v}" for k, v in found.found.worst.items())
    label = f"{objective}, worst at {worst}" if worst else objective
    before, after = found.start.objective, found.found.objective
    rows = [[label, f"{before:.5g}", f"{after:.5g}"]]
    return rows + [
        [key, f"{one:.5g}", f"{other:.5g}"]
        for key, (one, other) in found.margins.items()
    ]


def _page(
    composition: "Composition", found: "Tuned", objective: str, target: Path
) -> Path:
    from orchestrator.report.responded import Curve, write_responded

    curves = [
        Curve(
            f"{word} {r.breaks[0]}",
            r.hz,
            r.L[:, 0, 0],
            r.S[:, 0, 0],
            r.T[:, 0, 0],
            "other" if word == "before" else "own",
        )
        for word, of in zip(("before", "tuned"), found.responses, strict=True)
        for r in of.values()
    ]
    plain = [[name.removeprefix(">") for name in head] for head in (HEAD, FIGURES)]
    return write_responded(
        f"{composition.scenario.name} tuned",
        [f"{found.evaluations} runs"],
        [(plain[0], _values(found)), (plain[1], _figures(found, objective))],
        curves,
        {},
        target.with_suffix(".html"),
    )
