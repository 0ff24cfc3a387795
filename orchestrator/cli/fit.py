"""The verb ``fit``: parameters of models from measured data."""

from math import inf, isfinite
from pathlib import Path
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
from orchestrator.cli.rows import Between, Rate, interpolation, time
from orchestrator.cli.run import Json, ScenarioName, Verbose

if TYPE_CHECKING:
    from orchestrator.analysis.fit import Bracket, Fit

HEAD = ["value", ">found", ">standard error", ">95 % from", ">to", "unit", ">start"]


@executing
def fit(
    scenario: ScenarioName,
    data: Annotated[
        Path,
        typer.Option(
            help="CSV, Parquet or MAT; columns called plant.u [V]: inputs drive, "
            "others are compared"
        ),
    ],
    free: Annotated[
        str, typer.Option(metavar="NAMES", help="plant.m_2,plant.b_1,plant.state.x_1")
    ],
    bounds: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=LOW:HIGH",
            help="[a tenth to ten times the start value] (repeatable)",
        ),
    ] = [],  # noqa: B006 - Typer copies it
    unused: Annotated[
        float, typer.Option(help="share of the rows kept for the cross-check")
    ] = 0.25,
    between: Between = "hold",
    rate: Rate = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="scenario with the values found"),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Fit parameters to measured data; write the scenario that has them."""
    from orchestrator.analysis.fit import fit as fitted
    from orchestrator.analysis.fit import free_values, scenario_of
    from orchestrator.analysis.measured import beside
    from orchestrator.errors import ScenarioError
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.reading import load_scenario
    from orchestrator.session import naming, run_earlier

    set_up_logs(verbose)
    how, period = interpolation(between), time(rate, "--rate")
    if not 0 <= unused < 1:
        raise ScenarioError(f"--unused {unused:g}: is no share from 0 to below 1")
    loaded = load_scenario(scenario)
    with naming(loaded), waiting(f"fitting {loaded.name} to {data.name}"):
        composition = compose(loaded, run_earlier)
        measured = beside(composition, data, rate=period, interpolation=how)
        names = [name.strip() for name in free.split(",") if name.strip()]
        wanted = free_values(composition, names, dict(map(bracket, bounds)))
        found = fitted(composition, measured, wanted, unused)
    target = output or Path(f"{loaded.file.stem}_fitted.toml")
    scenario_of(composition, found, data, target)
    page = _page(found, f"{loaded.name} fitted to {data.name}", target)
    if json:
        rms = dict(found.rms)
        one = next(iter(rms.values())) if len(rms) == 1 else rms
        told = {"values": found.values(), "residual_rms": one, "scenario": str(target)}
        print_json(told)
        return
    print_table(HEAD, _rows(found), f"{loaded.name} fitted to {data.name}")
    for line in _words(found):
        echo(line)
    echo(f"scenario: {target}\nreport: {page}")


def bracket(text: str) -> "tuple[str, Bracket]":
    """Return the name and the ends of ``plant.m_2=0.1e-3:1e-3``."""
    from orchestrator.errors import ScenarioError

    name, _, written = text.partition("=")
    low, _, high = written.partition(":")
    try:
        ends = float(low), float(high)
    except ValueError:
        ends = inf, inf
    if not all(map(isfinite, ends)):
        raise ScenarioError(f"--bounds {text}: write plant.m_2=0.1e-3:1e-3")
    return name.strip(), ends


def _rows(found: "Fit") -> list[list[str]]:
    estimate = found.found
    return [
        [
            free.name,
            f"{estimate.values[i]:.6g}",
            f"{estimate.standard_errors[i]:.2g}",
            f"{estimate.intervals[i, 0]:.6g}",
            f"{estimate.intervals[i, 1]:.6g}",
            free.unit,
            f"{free.start:g}",
        ]
        for i, free in enumerate(found.free)
    ]


def _words(found: "Fit") -> list[str]:
    lines = []
    for name, rms in found.rms.items():
        unit, unused = found.units[name], found.rms_unused[name]
        text = f"{name}: residual {rms:.4g} {unit} rms over {found.used} rows"
        if unused is not None:
            rest = len(found.time) - found.used
            text += f", {unused:.4g} {unit} over {rest} rows not used"
        lines.append(text)
    names = [free.name for free in found.free]
    for i, name in enumerate(names):
        for j in range(i):
            r = found.found.correlation[i, j]
            lines.append(f"correlation of {names[j]} and {name}: {r:+.3f}")
    return [*lines, *found.words]


def _page(found: "Fit", title: str, target: Path) -> Path:
    from orchestrator.report.fitted import Compared, write_fitted

    signals = [
        Compared(name, found.units[name], found.measured[name], found.simulated[name])
        for name in found.measured
    ]
    head = [name.removeprefix(">") for name in HEAD]
    path = target.with_suffix(".html")
    until = float(found.time[found.used - 1])
    return write_fitted(
        title, head, _rows(found), _words(found), found.time, until, signals, path
    )
