"""Published figures of a study against what its FMUs give.

``reference.toml`` (see ``reference.py``) says where each of our values comes from;
every distinct run and call is made once.  Verdicts: ``FAILED``
(acceptance missed, or the run does not have the figure), ``matches`` or
``differs`` (against the published number), ``holds`` (acceptance met, nothing
numeric published), ``computed``, ``out of reach``.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.history.folder import Begun, taken
from orchestrator.quantity import NoValue, Quantity
from orchestrator.reproduction.formula import evaluate_formula
from orchestrator.reproduction.reference import FigureSpec, read_reference
from orchestrator.scenario.design import find_function
from orchestrator.scenario.reading import find_study

if TYPE_CHECKING:
    from orchestrator.outcome import Run

Job: TypeAlias = tuple[str, tuple[str, ...]]
Told: TypeAlias = Callable[[str], None]


@dataclass(frozen=True)
class Figure:
    """A published figure, ours, and the verdict; ``difference`` is ours - published.

    ``lost`` says why the run did not have the figure it should have.
    """

    spec: FigureSpec
    value: float | None
    verdict: str
    lost: str = ""

    @property
    def difference(self) -> float | None:
        published = self.spec.published
        if self.value is None or not isinstance(published, float | int):
            return None
        return self.value - published

    @property
    def why(self) -> str:
        """Why ours is missing or far from the published one, as far as known."""
        return "; ".join(text for text in (self.lost, self.spec.why) if text)

    def row(self) -> dict[str, Any]:
        """Return the object that ``reproduce --json`` prints for this figure."""
        return {
            "id": self.spec.id,
            "where": self.spec.where,
            "published": self.spec.published,
            "value": self.value,
            "unit": self.spec.unit,
            "class": self.spec.class_,
            "verdict": self.verdict,
            "expected": self.spec.expected,
            "tolerance": self.spec.tolerance,
            "difference": self.difference,
            "why": self.why,
        }


def reproduce(
    study: str | Path,
    only: str = "*",
    *,
    processes: int | None = None,
    folder: Path | None = None,
    told: Told = lambda text: None,
) -> list[Figure]:
    """Return the figures of a study whose id fits the pattern ``only``.

    ``study`` is a study's name or folder.  Runs are kept in ``folder`` (default
    ``runs/<study>/reproduce/<n>``); ``told`` hears of each run that ends.  More than
    four runs share two ``processes``.

    Raises:
        FeedDriveError: no such study or figure, or a run that fails.
    """
    place = study if isinstance(study, Path) else find_study(study)
    reference = read_reference(place / "reference.toml")
    table = {spec.id: spec for spec in reference.figure}
    wanted = [spec for spec in reference.figure if fnmatchcase(spec.id, only)]
    if not wanted:
        raise ScenarioError(f"no figure fits {only!r}; {did_you_mean(only, table)}")
    needed = _with_ingredients(wanted, table)
    jobs = dict.fromkeys(
        _job(spec, place) for spec in needed if spec.scenario is not None
    )
    at_once = processes or (2 if len(jobs) > 4 else 1)
    changed = () if only == "*" else (f"--only {only}",)
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
        found = [_judge(spec, values[spec.id], reference.agreement) for spec in wanted]
        kept.complete({"study": place.name, "figures": [f.row() for f in found]})
    return found


def _with_ingredients(
    wanted: Sequence[FigureSpec], table: Mapping[str, FigureSpec]
) -> list[FigureSpec]:
    ordered: dict[str, FigureSpec] = {}
    entered: list[str] = []

    def enter(spec: FigureSpec) -> None:
        if spec.id in entered:
            raise ScenarioError(f"figure {spec.id} is made of itself")
        entered.append(spec.id)
        for name in spec.with_.values():
            enter(table[name])
        entered.remove(spec.id)
        ordered.setdefault(spec.id, spec)

    for spec in wanted:
        enter(spec)
    return list(ordered.values())


def _job(spec: FigureSpec, folder: Path) -> Job:
    return str(folder / f"{spec.scenario}.toml"), spec.set


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
    """Return what the design steps found, as figures ``design.<step>.<name>``."""
    composition = done.composition
    return {
        f"design.{step}.{name}": composition.parameter(f"{component}.{name}")
        for step, result in composition.designs.items()
        for component in composition.scenario.spec.design[step].sets
        for name in result.values
        if name in composition.fmus[component].variables
    }


def _value(
    spec: FigureSpec,
    folder: Path,
    measured: Mapping[Job, Mapping[str, Quantity]],
    called: dict[str, Any],
    values: Mapping[str, Quantity | None],
) -> Quantity | None:
    if spec.scenario is not None and spec.metric is not None:
        figures = measured[_job(spec, folder)]
        if spec.metric not in figures:
            remedy = did_you_mean(spec.metric, figures)
            raise ScenarioError(f"{spec.scenario} has no {spec.metric!r}; {remedy}")
        return figures[spec.metric].to(spec.unit)
    if spec.call is not None:
        return Quantity(_called(spec, called), spec.unit)
    if spec.formula is not None:
        return _made_of(spec, spec.formula, values)
    return None


def _made_of(
    spec: FigureSpec, formula: str, values: Mapping[str, Quantity | None]
) -> Quantity | None:
    ingredients = {name: values[of] for name, of in spec.with_.items()}
    for name, value in ingredients.items():
        if isinstance(value, NoValue):
            return NoValue(spec.unit, why=f"{spec.with_[name]}: {value.why}")
    known = {k: v.value for k, v in ingredients.items() if v is not None}
    if len(known) < len(ingredients):
        return None
    return Quantity(evaluate_formula(formula, known), spec.unit)


def _called(spec: FigureSpec, called: dict[str, Any]) -> float:
    assert spec.call is not None
    identity = f"{spec.call} {sorted(spec.arguments.items())}"
    if identity not in called:
        function = find_function(spec.call)
        try:
            called[identity] = function(**spec.arguments)
        except Exception as error:
            fault = f"{type(error).__name__}: {error}"
            raise ScenarioError(f"{spec.call} failed: {fault}") from error
    found = called[identity]
    if spec.key is None:
        return float(found)
    if spec.key not in found:
        remedy = did_you_mean(spec.key, found)
        raise ScenarioError(f"{spec.call} gives no {spec.key!r}; {remedy}")
    return float(found[spec.key])


def _judge(spec: FigureSpec, found: Quantity | None, agreement: float) -> Figure:
    if found is None:
        return Figure(spec, None, "out of reach")
    if isinstance(found, NoValue):
        return Figure(spec, None, "FAILED", found.why)
    value = found.value
    figure = Figure(spec, value, "")
    missed = (
        spec.expected is not None
        and spec.tolerance is not None
        and not abs(value - spec.expected) <= spec.tolerance
    )
    if missed:
        return replace(figure, verdict="FAILED")
    if isinstance(spec.published, float | int):
        limit = (spec.agreement or agreement) * abs(spec.published)
        matches = abs(value - spec.published) <= limit
        return replace(figure, verdict="matches" if matches else "differs")
    return replace(figure, verdict="computed" if spec.expected is None else "holds")
