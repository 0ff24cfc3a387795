"""What ``run --swap`` adds to a run: a proposal where names differ, and A against B.

The original runs in the subfolder ``original``; the report of the run overlays
both.  A map is never applied without having been given.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orchestrator.cli.output import echo, print_table, waiting
from orchestrator.cli.running import load, simulate
from orchestrator.evaluation.compare import change, number
from orchestrator.quantities.quantity import NoValue

if TYPE_CHECKING:
    from orchestrator.fmu.description import FmuDescription
    from orchestrator.outcome import Run
    from orchestrator.scenario.compose import Composition
    from orchestrator.scenario.pulse import Measured
    from orchestrator.scenario.reading import Scenario

ORIGINAL = "original"
SWAPPED = "swapped"
OF_BOTH = ("step", "offset", "latency")


def load_original(
    name: str,
    sets: list[str],
    swaps: list[str],
    maps: list[str],
    fmi: int | None,
    sockets: Sequence[str] = (),
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

    tables = parse_swaps(swaps, maps, sockets)
    elsewhere = [text for text in sets if text.partition(".")[0].strip() not in tables]
    original = load(name, elsewhere, [], [], fmi)
    with naming(original), waiting("comparing names"):
        composition = compose(original, run_earlier)
        _refuse_other_names(composition, tables)
    kept = [text for text in sets if text in elsewhere or _shared(text, composition)]
    for text in sets:
        if text not in kept:
            echo(f"original: without --set {text}, which it lacks", err=True)
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
    from orchestrator.errors import ScenarioError
    from orchestrator.scenario.propose import lacking

    for component, theirs in _without_map(swaps).items():
        if missing := lacking(original.system, component, theirs):
            raise ScenarioError(
                f"--swap {component}: {theirs.path.name} has no {', '.join(missing)}. "
                f"A map is proposed below and was not applied: check every line and "
                f"the signs, save it as map.toml (--map-out map.toml does) and add "
                f"--map map.toml\n\n{_proposal(original, component, theirs)}"
            )


def _without_map(
    swaps: Mapping[str, Mapping[str, Any]],
) -> "dict[str, FmuDescription]":
    """Return the FMUs of swaps for which no map is given, by component."""
    from fmus.build import build
    from orchestrator.fmu.description import read_fmu

    files = {
        name: str(swap["fmu"]) for name, swap in swaps.items() if "map" not in swap
    }
    return {
        name: read_fmu(file if file.endswith(".fmu") else build(file))
        for name, file in files.items()
    }


def _proposal(original: "Composition", component: str, theirs: "FmuDescription") -> str:
    from orchestrator.scenario.propose import proposal

    return proposal(original.system, component, original.fmus[component], theirs)


def propose_map(
    name: str, sets: list[str], swaps: list[str], fmi: int | None, file: Path
) -> str:
    """Write the map that is proposed for a swap, and return it.

    Raises:
        ScenarioError: there is not one swap, or the file is there already: somebody
            may have edited it.
    """
    from orchestrator.errors import ScenarioError
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.override import parse_swaps
    from orchestrator.session import naming, run_earlier

    found = _without_map(parse_swaps(swaps, []))
    if len(found) != 1:
        raise ScenarioError("--map-out: write one --swap whose map is to be proposed")
    ((component, theirs),) = found.items()
    elsewhere = [t for t in sets if t.partition(".")[0].strip() != component]
    original = load(name, elsewhere, [], [], fmi)
    with naming(original), waiting("comparing names and answers"):
        text = _proposal(compose(original, run_earlier), component, theirs)
    try:
        with file.open("x", encoding="utf-8") as new:
            new.write(text)
    except FileExistsError:
        raise ScenarioError(
            f"--map-out {file}: there is such a file; name another"
        ) from None
    return text


def compare(
    original: "Scenario", swapped: "Run", swaps: list[str], **options: Any
) -> "tuple[Run, list[Measured]]":
    """Run the original too and overlay both in the report.

    Returns its run, and how an FMU file answers short pulses beside it; an answer
    the other way round is warned of.
    """
    from orchestrator.report.page import write_report
    from orchestrator.scenario.pulse import answers
    from orchestrator.warned import warn

    first = simulate(original, swapped.folder / ORIGINAL, report=False, **options)
    parts = _parts(swaps)
    both = first.composition, swapped.composition
    found = [
        one
        for component, _, _ in parts
        if swapped.composition.sources[component].endswith(".fmu")
        for one in answers(*both, component)
    ]
    for one in found:
        if one.ratio < 0:
            text = (
                f"{one.output} answers a pulse on {one.input} the other way round "
                f"({one.ratio:+.3g} times the original's): is a sign of the map wrong?"
            )
            warn(text)
            swapped.warnings += (text,)
    names = ", ".join(f"{c} = {Path(f).name}" for c, _, f in parts)
    title = swapped.scenario.spec.title or swapped.scenario.name
    with waiting("writing the report"):
        runs = [_titled(first, ORIGINAL), _titled(swapped, SWAPPED)]
        write_report(runs, swapped.folder / "report.html", f"{title}: {names}")
    return first, found


def _parts(swaps: Sequence[str]) -> list[tuple[str, str, str]]:
    return [text.partition("=") for text in swaps]


def _titled(run: "Run", title: str) -> "Run":
    from orchestrator.outcome import Run

    spec = run.scenario.spec.model_copy(update={"title": title})
    scenario = replace(run.scenario, spec=spec)
    composition = replace(run.composition, scenario=scenario)
    told = run.metrics, run.checks, run.diverged, run.warnings, None, run.unlike
    return Run(run, composition, *told)


def print_swap(first: "Run", second: "Run", answers: "Sequence[Measured]") -> None:
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
    if answers:
        told = ", ".join(f"{a.input} -> {a.output} {a.ratio:+.4g}" for a in answers)
        echo(f"answers to a short pulse, {SWAPPED} over {ORIGINAL}: {told}")
    if first.diverged:
        echo(f"{ORIGINAL}: {first.diverged}")
    for run, name in ((first, ORIGINAL), (second, SWAPPED)):
        for figure, value in run.metrics.items():
            if isinstance(value, NoValue):
                echo(f"{name}: {figure}: {value.why}")
