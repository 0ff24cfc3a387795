"""A scenario from end to end: compose, lock, simulate, evaluate, report.

What the folder of a run holds stands in ``history.folder``.  It is taken when
nothing is left that could be refused, and the lock is written before the first
step, so that a run that fails can be looked at and run again.
"""

import atexit
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import count
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Any

from fmus.units import UnitError
from orchestrator.errors import FeedDriveError, ScenarioError, SimulationError
from orchestrator.evaluation.baseline import unlike
from orchestrator.evaluation.compared import refuse_apart
from orchestrator.evaluation.divergence import divergence
from orchestrator.evaluation.expectation import check
from orchestrator.evaluation.metrics import evaluate, unit_doubts
from orchestrator.folders.temporary import temporary_folder
from orchestrator.history.folder import ORIGIN, Begun, RunFolder, taken, taken_again
from orchestrator.outcome import Run
from orchestrator.quantities.quantity import parse_period, time_text
from orchestrator.result import Result
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.lock import LOCK, write_lock
from orchestrator.scenario.reading import Scenario, load_scenario
from orchestrator.warned import collecting

if TYPE_CHECKING:
    from orchestrator.master.checkpoint import Checkpoints
    from orchestrator.master.simulate import Choice
    from orchestrator.master.timetable import Timetable
    from orchestrator.master.warm import Origin

Progress = Callable[[Fraction], None]
Also = Callable[[Run], Mapping[str, Any]]
Watched = Callable[[Path, "Timetable"], None]


def run(
    scenario: Scenario | str | Path,
    folder: str | Path | None = None,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    report: bool = True,
) -> Run:
    """Run a scenario and return its recorded signals, figures and checks.

    ``folder`` (default ``runs/<study>/<scenario>/<n>``, the next n) takes the files
    of the run; one that holds a run loses it with ``overwrite``.  ``progress`` is
    told the simulated time.

    Raises:
        FeedDriveError: the scenario cannot be run, or the run failed.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario)
    target = None if folder is None else Path(folder)
    with naming(scenario):
        composition = compose(scenario, run_earlier)
        return execute(
            composition, target, overwrite=overwrite, progress=progress, report=report
        )


def execute(
    composition: Composition,
    folder: Path | None = None,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    report: bool = True,
    executor: "Choice | None" = None,
    profile: bool = False,
    pace: float | None = None,
    checkpoint: Fraction | None = None,
    kept: bool = False,
    origin: "Origin | None" = None,
    also: Also = lambda done: {},
    watched: Watched = lambda folder, timetable: None,
) -> Run:
    """Simulate a composition into a folder of its own and evaluate it.

    ``folder`` and ``overwrite`` as for ``run``, ``executor``, ``profile`` and ``pace``
    as for ``simulate``.  ``checkpoint``: so much simulated time (s) lies between two
    points from which ``resume`` can go on, and all are ``kept`` if that is asked; the
    run begins at one that is its ``origin``, else at 0.  What ``also`` returns belongs
    to the figures of the run, which is not complete before.  ``watched`` is told its
    folder before the first step.

    Raises:
        FeedDriveError: the system does not fit together, or the run failed.
    """
    from orchestrator.master.checkpoint import Checkpoints, refuse_options
    from orchestrator.master.simulate import plan
    from orchestrator.master.warm import Warm

    refuse_metrics(composition)
    timetable = plan(composition.system)
    _refuse_apart(composition, timetable, origin)
    refuse_own_folder(folder, composition)
    saves, paced = bool(checkpoint or origin), pace is not None
    refuse_options(timetable, executor, profile=profile, saves=saves, paced=paced)
    begun, checkpoints = _begun(composition), None
    if saves:
        _refuse_baseline(composition)
    if checkpoint is not None:
        begun = replace(begun, checkpoint=time_text(checkpoint), kept=kept)
        checkpoints = Checkpoints(checkpoint, kept=kept)
    if origin is not None:
        Warm(origin, timetable)  # refused before there is a folder
        begun = replace(begun, origin=origin.run)
    with taken(folder, begun, overwrite=overwrite) as place:
        write_lock(composition, place.path, str(origin) if origin else None)
        if origin is not None:
            copyfile(origin.file, place.path / ORIGIN)
        watched(place.path, timetable)
        options = {"executor": executor, "profile": profile, "pace": pace}
        done = _evaluated(
            composition, timetable, place, progress, checkpoints, origin, **options
        )
        _complete(done, place, report=report, also=also)
    return done


def resume(folder: Path, progress: Progress | None = None) -> tuple[Run, Begun]:
    """Go on with a run that has checkpoints, from its lock, in its folder.

    Raises:
        FeedDriveError: there is nothing to go on with, or the run failed.
    """
    from orchestrator.master.checkpoint import Checkpoints
    from orchestrator.master.saved import read
    from orchestrator.master.simulate import plan
    from orchestrator.master.warm import Origin

    with taken_again(folder) as (place, begun):
        if not (folder / LOCK).is_file():
            raise ScenarioError(f"{folder}: ended before it was written down; run anew")
        scenario = load_scenario(folder / LOCK)
        with naming(scenario):
            composition = compose(scenario, run_earlier, warm=True)
            timetable = plan(composition.system)
            every, first = parse_period(begun.checkpoint), folder / ORIGIN
            checkpoints = Checkpoints(every, resumed=True, kept=begun.kept)
            origin = begun.origin and Origin(begun.origin, first, read(first))
            done = _evaluated(
                composition, timetable, place, progress, checkpoints, origin or None
            )
            _complete(done, place)
    return done, begun


def _complete(
    done: Run, place: RunFolder, *, report: bool = True, also: Also = lambda done: {}
) -> None:
    if report:
        from orchestrator.report.page import write_report

        write_report([done], place.path / "report.html")
    place.complete({**done.summary(), **also(done)})


def _refuse_baseline(composition: Composition) -> None:
    if composition.scenario.spec.expect_like is not None:
        raise ScenarioError(
            "checkpoints: a run that is resumed, or begins at one, is not compared "
            "with a baseline (expect_like), which its lock does not hold; run without "
            "--checkpoint and --from"
        )


def _refuse_apart(
    composition: Composition, timetable: "Timetable", origin: "Origin | None"
) -> None:
    tables, stop = timetable.wiring.tables, composition.system.stop
    begin = origin.time if origin else Fraction(0)
    for name, metric in composition.scenario.spec.metrics.items():
        try:
            refuse_apart(metric, tables, stop, begin)
        except ScenarioError as error:
            raise ScenarioError(f"metrics.{name}: {error}") from None


def _begun(composition: Composition) -> Begun:
    scenario = composition.scenario
    changed = (*(f"--swap {swap}" for swap in scenario.swapped), *scenario.overrides)
    return Begun("run", scenario.name, changed, float(composition.system.stop))


def _evaluated(
    composition: Composition,
    timetable: "Timetable",
    place: RunFolder,
    progress: Progress | None,
    checkpoints: "Checkpoints | None",
    origin: "Origin | None",
    **options: Any,
) -> Run:
    from orchestrator.master.simulate import simulate

    spec, parameter = composition.scenario.spec, composition.parameter
    try:
        with collecting() as warnings:
            result = simulate(
                composition.system,
                place.path,
                timetable=timetable,
                progress=progress,
                checkpoints=checkpoints,
                origin=origin,
                **options,
            )
    except SimulationError as error:
        if told := _diverged_before(composition, place.path):
            raise type(error)(f"{error}; {told}") from error.__cause__
        raise
    begin = origin.time if origin else Fraction(0)
    figures = evaluate(spec.metrics, result, parameter, result.ended, begin)
    diverged = divergence(spec.metrics, result, parameter)
    return Run(
        result,
        composition,
        figures,
        check(spec.expected_of_run, figures),
        diverged,
        (*composition.warnings, *warnings, *_not_measured(composition)),
        place.number,
        unlike(composition.scenario.file, spec.expect_like, result),
    )


def _not_measured(composition: Composition) -> list[str]:
    """Say that a run does not carry out the responses of its scenario."""
    names = ", ".join(composition.scenario.spec.responses)
    if not names:
        return []
    return [
        f"responses {names}: a run does not measure them, nor what is expected of "
        f"them; `feeddrive response {composition.scenario.name}` does, and pytest"
    ]


def _diverged_before(composition: Composition, folder: Path) -> str | None:
    """Return what diverged before a run failed, in words, if anything did."""
    metrics = composition.scenario.spec.metrics
    try:
        return divergence(metrics, Result(folder), composition.parameter)
    except Exception:  # the failure itself is what counts, whatever its rows are like
        return None


def refuse_metrics(composition: Composition) -> None:
    """Refuse, before the run, metrics that cannot be taken after it.

    Raises:
        ScenarioError: a signal is not recorded, a parameter is missing, or the
            unit does not fit; the message names the metric.
    """
    recorded = composition.system.record
    for name, metric in composition.scenario.spec.metrics.items():
        for key, signal in metric.signals().items():
            try:
                composition.refuse_text(signal)
            except ScenarioError as error:
                raise ScenarioError(
                    f"metrics.{name}.{key}: {signal}: {error}"
                ) from None
            if not any(r == signal or signal.startswith(f"{r}[") for r in recorded):
                raise ScenarioError(
                    f"metrics.{name}.{key}: {signal} is not recorded; add "
                    f'"{signal}" = true to [record]'
                )
        try:
            unit_doubts(metric, composition.unit, composition.parameter)
        except (ScenarioError, UnitError) as error:
            raise ScenarioError(f"metrics.{name}: {error}") from None


def refuse_own_folder(folder: Path | None, composition: Composition) -> None:
    """Refuse a folder that holds what is to be run.

    Raises:
        ScenarioError: the lock file or an FMU of the system lies in it.
    """
    if folder is None or not (folder / LOCK).is_file():
        return
    inputs = [c.fmu for c in composition.system.components.values()]
    inputs.append(composition.scenario.file)
    place = folder.resolve()
    if any(path.resolve().is_relative_to(place) for path in inputs):
        raise ScenarioError(
            f"{folder}: holds the run that is to be run again; give another folder "
            f"with -o"
        )


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
        told = type(error)(f"{scenario.file}: {error}")
        told.folder = error.folder
        raise told from error.__cause__
