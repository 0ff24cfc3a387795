"""A scenario from end to end: compose, lock, simulate, evaluate, report.

The folder of a run holds ``scenario.lock.toml`` with ``fmus/``, ``result/``,
``metrics.json`` and ``report.html``.  The lock is written before the first
step, so that a run that fails can be looked at and run again.
"""

import atexit
import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from fractions import Fraction
from functools import cache
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from fmus.units import UnitError
from orchestrator.errors import FeedDriveError, ScenarioError, SimulationError
from orchestrator.evaluation.divergence import divergence
from orchestrator.evaluation.expectation import check
from orchestrator.evaluation.metrics import evaluate, unit_doubts
from orchestrator.outcome import Run
from orchestrator.result import Result
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.lock import LOCK, write_lock
from orchestrator.scenario.reading import Scenario, load_scenario
from orchestrator.temporary import temporary_folder
from orchestrator.warned import collecting

if TYPE_CHECKING:
    from orchestrator.simulate import Choice

Progress = Callable[[Fraction], None]


def run(
    scenario: Scenario | str | Path,
    folder: str | Path | None = None,
    *,
    progress: Progress | None = None,
    report: bool = True,
) -> Run:
    """Run a scenario and return its recorded signals, figures and checks.

    ``folder`` (default ``runs/<scenario>``) takes the files of the run and loses
    those of an earlier one.  ``progress`` is told the simulated time.

    Raises:
        FeedDriveError: the scenario cannot be run, or the run failed.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario)
    target = Path("runs", scenario.name) if folder is None else Path(folder)
    with naming(scenario):
        composition = compose(scenario, run_earlier)
        return execute(composition, target, progress=progress, report=report)


def execute(
    composition: Composition,
    folder: Path,
    *,
    progress: Progress | None = None,
    report: bool = True,
    executor: "Choice | None" = None,
    profile: bool = False,
) -> Run:
    """Simulate a composition into a folder and evaluate it.

    ``executor`` and ``profile`` as in ``simulate``.

    Raises:
        FeedDriveError: the system does not fit together, or the run failed.
    """
    from orchestrator.simulate import simulate

    refuse_metrics(composition)
    clear(folder, composition)
    write_lock(composition, folder)
    spec = composition.scenario.spec
    try:
        with collecting() as warnings:
            result = simulate(
                composition.system,
                folder,
                progress=progress,
                executor=executor,
                profile=profile,
            )
    except SimulationError as error:
        begun = Result(folder) if (folder / "result").is_dir() else {}
        if told := divergence(spec.metrics, begun, composition.parameter):
            raise type(error)(f"{error}; {told}") from error.__cause__
        raise
    figures = evaluate(spec.metrics, result, composition.parameter)
    diverged = divergence(spec.metrics, result, composition.parameter)
    checks = check(spec.expect, figures)
    noted = (*composition.warnings, *warnings)
    done = Run(result, composition, figures, checks, diverged, noted)
    summary = json.dumps(done.summary(), indent=2) + "\n"
    (folder / "metrics.json").write_text(summary, encoding="utf-8")
    if report:
        from orchestrator.report.page import write_report

        write_report([done], folder / "report.html")
    return done


def refuse_metrics(composition: Composition) -> None:
    """Refuse, before the run, metrics that cannot be taken after it.

    Raises:
        ScenarioError: a signal is not recorded, a parameter is missing, or the
            unit does not fit; the message names the metric.
    """
    recorded = composition.system.record
    for name, metric in composition.scenario.spec.metrics.items():
        for key, signal in metric.signals().items():
            if not any(r == signal or signal.startswith(f"{r}[") for r in recorded):
                raise ScenarioError(
                    f"metrics.{name}.{key}: {signal} is not recorded; add "
                    f'"{signal}" = true to [record]'
                )
        try:
            unit_doubts(metric, composition.unit, composition.parameter)
        except (ScenarioError, UnitError) as error:
            raise ScenarioError(f"metrics.{name}: {error}") from None


def clear(folder: Path, composition: Composition) -> None:
    """Make a run folder, or empty one that holds an earlier run.

    Raises:
        ScenarioError: the folder holds other things, or what is to be run.
    """
    inputs = [c.fmu for c in composition.system.components.values()]
    inputs.append(composition.scenario.file)
    place = folder.resolve()
    within = any(path.resolve().is_relative_to(place) for path in inputs)
    if within and (folder / LOCK).is_file():
        raise ScenarioError(
            f"{folder}: holds the run that is to be run again; give another folder "
            f"with -o"
        )
    if folder.is_dir() and any(folder.iterdir()) and not (folder / LOCK).is_file():
        raise ScenarioError(
            f"{folder}: holds files that are no run; give another folder with -o"
        )
    if folder.is_file():
        raise ScenarioError(f"{folder}: is a file; give a folder with -o")
    for name in ("result", "fmus"):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in ("metrics.json", "report.html"):
        (folder / name).unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)


_UNDER_WAY: list[str] = []
_NUMBERS = count()


@cache
def run_earlier(name: str) -> Run:
    """Return the run of a scenario by name or path; once per process.

    Raises:
        ScenarioError: the scenario needs its own result.
    """
    if name in _UNDER_WAY:
        raise ScenarioError(f"from_run: {name} takes signals from its own run")
    _UNDER_WAY.append(name)
    try:
        return run(name, _workspace() / str(next(_NUMBERS)), report=False)
    finally:
        _UNDER_WAY.remove(name)


@cache
def _workspace() -> Path:
    kept = ExitStack()
    atexit.register(kept.close)
    return kept.enter_context(temporary_folder())


@contextmanager
def naming(scenario: Scenario) -> Iterator[None]:
    """Put the scenario's file in front of errors that do not name it."""
    try:
        yield
    except FeedDriveError as error:
        if str(scenario.file) in str(error):
            raise
        raise type(error)(f"{scenario.file}: {error}") from error.__cause__
