"""Published figures of a study against what its FMUs give.

``reference.toml`` (see ``reference.py``) says where each of our values comes from;
every distinct run and call is made once.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from fnmatch import fnmatchcase
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.history.folder import Begun, taken
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.reproduction.formula import evaluate_formula
from orchestrator.reproduction.reference import (
    FigureSpec,
    Reference,
    Source,
    read_reference,
)
from orchestrator.reproduction.verdict import Figure, judge_figure, summary
from orchestrator.scenario.design import find_function
from orchestrator.scenario.reading import find_study

if TYPE_CHECKING:
    from orchestrator.outcome import Run

Job: TypeAlias = tuple[str, tuple[str, ...]]
Told: TypeAlias = Callable[[str], None]


@dataclass(frozen=True)
class Reproduction:
    """A study's figures as far as they were wanted, and the tables they stand in.

    ``folder`` has the runs they are from.
    """

    reference: Reference
    figures: tuple[Figure, ...]
    folder: Path

    def as_json(self, study: str) -> dict[str, Any]:
        """Return the object that ``reproduce --json`` prints."""
        rows = [figure.row() for figure in self.figures]
        return {"study": study, "summary": summary(self.figures), "figures": rows}


def reproduce(
    study: str | Path,
    only: str | Collection[str] = "*",
    *,
    processes: int | None = None,
    folder: Path | None = None,
    told: Told = lambda text: None,
) -> Reproduction:
    """Return the figures of a study whose id fits the pattern ``only``, or is in it.

    ``study`` is a study's name or folder.  Runs are kept in ``folder`` (default
    ``runs/<study>/reproduce/<n>``); ``told`` hears of each run that ends.  More than
    four runs share two ``processes``.

    Raises:
        FeedDriveError: no such study or figure, or a run that fails.
    """
    place = study if isinstance(study, Path) else find_study(study)
    reference = read_reference(place / "reference.toml")
    table = reference.figures
    wanted = _wanted(table, only)
    needed = _needed(wanted, table)
    sources = [source for spec in needed for source in spec.sources()]
    jobs = dict.fromkeys(
        job
        for source in sources
        if source.scenario is not None
        for job in _jobs(source, place)
    )
    at_once = processes or (2 if len(jobs) > 4 else 1)
    changed = (f"--only {only}",) if isinstance(only, str) and only != "*" else ()
    begun = Begun("reproduce", f"{place.name}/reproduce", changed)
    with taken(folder, begun) as kept:
        measured = run_all(list(jobs), kept.path, at_once, told)
        called: dict[str, Any] = {}
        values: dict[str, Quantity | None] = {}
        for spec in needed:  # ingredients come before what is made of them
            try:
                values[spec.id] = _value(spec, place, measured, called, values)
            except ScenarioError as error:
                raise ScenarioError(f"{place.name}: {spec.id}: {error}") from None
        figures = (judge_figure(spec, values, reference.agreement) for spec in wanted)
        done = Reproduction(reference, tuple(figures), kept.path)
        kept.complete(done.as_json(place.name))
    return done


def _wanted(
    table: Mapping[str, FigureSpec], only: str | Collection[str]
) -> list[FigureSpec]:
    if isinstance(only, str):
        wanted = [spec for spec in table.values() if fnmatchcase(spec.id, only)]
        if not wanted:
            remedy = did_you_mean(only, table)
            raise ScenarioError(f"no figure fits {only!r}; {remedy}")
        return wanted
    return [spec for spec in table.values() if spec.id in only]


def _needed(
    wanted: Sequence[FigureSpec], table: Mapping[str, FigureSpec]
) -> list[FigureSpec]:
    """Return the figures wanted and those held against them, ingredients first."""
    ordered: dict[str, FigureSpec] = {}
    entered: list[str] = []

    def enter(spec: FigureSpec) -> None:
        if spec.id in entered:
            raise ScenarioError(f"figure {spec.id} is made of itself")
        entered.append(spec.id)
        for source in spec.sources():
            for of in source.with_.values():
                if isinstance(of, str):
                    enter(table[of])
        entered.remove(spec.id)
        ordered.setdefault(spec.id, spec)

    for spec in wanted:
        enter(spec)
        if spec.other is not None:
            enter(table[spec.other])
    return list(ordered.values())


def _jobs(source: Source, folder: Path) -> list[Job]:
    """Return the run of a source, or its repeats."""
    file = str(folder / f"{source.scenario}.toml")
    if source.repeats is None:
        return [(file, source.set)]
    return [(file, source.set + moved) for moved in source.repeats.sets()]


def run_all(
    jobs: Sequence[Job], runs: Path, processes: int, told: Told
) -> dict[Job, dict[str, Quantity]]:
    """Run each scenario once, some at a time; return their figures."""
    measured = {}
    folders = {
        job: runs / f"{number:03d}_{Path(job[0]).stem}"
        for number, job in enumerate(jobs)
    }
    if processes == 1 or len(jobs) == 1:
        for job in jobs:
            measured[job] = run_job(job, folders[job])
            told(Path(job[0]).stem)
        return measured
    # spawned, not forked: native libraries do not survive a fork with threads
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        futures = {pool.submit(run_job, job, folders[job]): job for job in jobs}
        try:
            for future in as_completed(futures):
                measured[futures[future]] = future.result()
                told(Path(futures[future][0]).stem)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return measured


def run_job(job: Job, folder: Path) -> dict[str, Quantity]:
    """Run one scenario with its overrides and return its figures."""
    from orchestrator.scenario.reading import load_scenario
    from orchestrator.session import run

    name, overrides = job
    done = run(load_scenario(name, overrides), folder, report=False)
    return {**done.metrics, **_designed(done)}


def _designed(done: "Run") -> dict[str, Quantity]:
    """Return what the design steps found, as figures ``design.<step>.<name>``.

    Elements of an array are called ``<name>[1]`` and so forth.
    """
    composition = done.composition
    found: dict[str, Quantity] = {}
    for step, result in composition.designs.items():
        for component in composition.scenario.spec.design[step].sets:
            variables = composition.fmus[component].variables
            for name, value in result.values.items():
                figure, parameter = f"design.{step}.{name}", f"{component}.{name}"
                if isinstance(value, tuple | list):
                    unit = composition.unit(parameter)
                    found |= {
                        f"{figure}[{i}]": Quantity(float(element), unit)
                        for i, element in enumerate(value, 1)
                    }
                elif name in variables:
                    found[figure] = composition.parameter(parameter)
    return found


def _value(
    source: Source,
    folder: Path,
    measured: Mapping[Job, Mapping[str, Quantity]],
    called: dict[str, Any],
    values: Mapping[str, Quantity | None],
) -> Quantity | None:
    if source.scenario is not None and source.metric is not None:
        runs = [measured[job] for job in _jobs(source, folder)]
        if source.metric not in runs[0]:
            remedy = did_you_mean(source.metric, runs[0])
            raise ScenarioError(f"{source.scenario} has no {source.metric!r}; {remedy}")
        found = [figures[source.metric].to(source.unit) for figures in runs]
        return found[0] if source.repeats is None else source.repeats.of(found)
    if source.call is not None:
        return Quantity(_called(source, source.call, called), source.unit)
    if source.formula is not None:
        of = {
            name: values[of]
            if isinstance(of, str)
            else _value(of, folder, measured, called, values)
            for name, of in source.with_.items()
        }
        return _made_of(source, source.formula, of)
    return None


def _made_of(
    source: Source, formula: str, ingredients: Mapping[str, Quantity | None]
) -> Quantity | None:
    known: dict[str, float] = {}
    for name, value in ingredients.items():
        if isinstance(value, NoValue):
            return NoValue(source.unit, why=f"{name}: {value.why}")
        if value is None:
            return None
        known[name] = value.value
    return Quantity(evaluate_formula(formula, known), source.unit)


def _called(source: Source, call: str, called: dict[str, Any]) -> float:
    identity = f"{call} {sorted(source.arguments.items())}"
    if identity not in called:
        function = find_function(call)
        try:
            called[identity] = function(**source.arguments)
        except Exception as error:
            fault = f"{type(error).__name__}: {error}"
            raise ScenarioError(f"{call} failed: {fault}") from error
    found = called[identity]
    if source.key is None:
        return float(found)
    if source.key not in found:
        remedy = did_you_mean(source.key, found)
        raise ScenarioError(f"{call} gives no {source.key!r}; {remedy}")
    return float(found[source.key])
