"""The members of a sweep, carried out: in lanes, or with the FMUs kept loaded.

Members whose settings change more than parameters and start values (rates,
latencies, FMUs, designs, the stop) have a composition of their own; the others
share one.  A composition whose FMUs are all ours runs in lanes on all cores;
any other in processes and libraries that stay loaded, one per core, from one
composition to the next.  An FMU whose process ends is loaded again and the member
repeated once: then it has failed.  A design is told the nominal values, whatever is
varied, unless ``design.*`` itself is.
"""

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import islice
from typing import TypeAlias

from fmus.compile import CompileError
from orchestrator.analysis.variations import Assignment, Setting
from orchestrator.analysis.width import width
from orchestrator.errors import (
    FeedDriveError,
    ProcessEnded,
    ScenarioError,
    SimulationError,
)
from orchestrator.evaluation.divergence import divergence
from orchestrator.evaluation.expectation import Check, check
from orchestrator.evaluation.metrics import evaluate
from orchestrator.fmu import laid
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.groups import only_python
from orchestrator.master.loaded import Loaded
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.quantities.quantity import Quantity, parse_quantity
from orchestrator.result import End, Recorded
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.override import OF_COMPONENT
from orchestrator.system import Value, split_name

AHEAD = 3  # batches given to each core before one is taken back
SMALL = 4  # members that a loaded system runs in one batch
MANY = 32  # members from which on the seconds of compiling lanes are won back


@dataclass(frozen=True)
class Outcome:
    """What came of a member: its figures and checks, or why it failed.

    One that diverged has failed, and figures.
    """

    index: int
    figures: Mapping[str, Quantity]
    checks: Sequence[Check] = ()
    failure: str | None = None

    @property
    def met(self) -> bool:
        """Tell whether the member ran and met every expectation."""
        return self.failure is None and all(c.met for c in self.checks)


@dataclass(frozen=True)
class Job:
    """A member to be run: what is set beside its group's composition."""

    index: int
    values: Mapping[str, Mapping[str, Value]]


Work: TypeAlias = Callable[[Sequence[Job]], list[Outcome]]
Outcomes: TypeAlias = Iterator[Outcome]


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


class Workers:
    """The cores of this machine, each with FMUs that it keeps loaded."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(cores())
        self._mine = threading.local()
        self._all: list[Loaded] = []

    @property
    def loaded(self) -> Loaded:
        """The FMUs of the core that asks."""
        if not hasattr(self._mine, "loaded"):
            self._mine.loaded = Loaded()
            self._all.append(self._mine.loaded)
        found: Loaded = self._mine.loaded
        return found

    def carry_out(self, work: Work, batches: Iterable[Sequence[Job]]) -> Outcomes:
        """Yield what comes of batches of jobs, as it comes."""
        left = iter(batches)
        waiting = {self._pool.submit(work, b) for b in islice(left, AHEAD * cores())}
        try:
            while waiting:
                done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                for future in done:
                    for batch in islice(left, 1):
                        waiting.add(self._pool.submit(work, batch))
                    yield from future.result()
        finally:
            for future in waiting:
                future.cancel()

    def close(self) -> None:
        """Free all FMUs."""
        self._pool.shutdown(cancel_futures=True)
        for loaded in self._all:
            loaded.drop()

    def __call__(self, composition: Composition, count: int) -> "Group":
        """Return the runner of a composition's members."""
        return Group(composition, count, self)


class Group:
    """Members of one composition, of which ``count`` are to come."""

    def __init__(self, composition: Composition, count: int, workers: Workers) -> None:
        self.composition = composition
        self._workers = workers
        self._timetable = plan(composition.system)
        self._own = cache(composition.parameter)
        spec = composition.scenario.spec
        self._signals = frozenset(
            s for m in spec.metrics.values() for s in m.signals().values()
        )
        self.executor = "python" if only_python(self._timetable.wiring) else "kernel"
        if count >= MANY:
            with suppress(SimulationError, CompileError):
                self._lanes = Lanes(self._timetable, self._signals, width())
                self.executor = "lanes"

    def run(self, jobs: Sequence[Job]) -> Outcomes:
        """Yield the outcome of every job, as it comes."""
        work: Work = self._loaded
        size = min(SMALL, -(-len(jobs) // cores()))
        if self.executor == "lanes":
            work, size = self._in_lanes, 2 * width()
        batches = (jobs[i : i + size] for i in range(0, len(jobs), size))
        yield from self._workers.carry_out(work, batches)

    def _in_lanes(self, jobs: Sequence[Job]) -> list[Outcome]:
        members = self._lanes.run([job.values for job in jobs])
        found = []
        alone = []
        for job, member in zip(jobs, members, strict=True):
            if member.unsettled:
                alone.append(job)
            elif member.failure is not None:
                found.append(Outcome(job.index, {}, failure=str(member.failure)))
            else:
                found.append(self._evaluated(job, member.signals))
        return found + self._loaded(alone)

    def _loaded(self, jobs: Sequence[Job]) -> list[Outcome]:
        loaded = self._workers.loaded
        series = Series(self._timetable, self._signals, loaded)
        found = []
        for job in jobs:
            try:
                try:
                    signals, ended = series.run(job.values)
                except ProcessEnded:  # killed from outside, or it would do so again
                    signals, ended = series.run(job.values)
                found.append(self._evaluated(job, signals, ended))
            except FeedDriveError as error:
                found.append(Outcome(job.index, {}, failure=str(error)))
        return found

    def _evaluated(
        self, job: Job, signals: Recorded, ended: End | None = None
    ) -> Outcome:
        spec = self.composition.scenario.spec

        member = cache(lambda: self.composition.with_values(job.values))

        def parameter(name: str) -> Quantity:
            own = split_name(name)[0] not in job.values
            return self._own(name) if own else member().parameter(name)

        try:
            figures = evaluate(spec.metrics, signals, parameter, ended)
            diverged = divergence(spec.metrics, signals, parameter)
            checks = check(spec.expected_of_run, figures)
            return Outcome(job.index, figures, checks, diverged)
        except FeedDriveError as error:
            return Outcome(job.index, {}, failure=str(error))


def split(
    composition: Composition, assignment: Assignment
) -> tuple[dict[str, dict[str, Value]], tuple[str, ...]]:
    """Return what of an assignment is a number written to a component before its
    start, and what else is set, as ``--set`` takes it."""
    values: dict[str, dict[str, Value]] = {}
    sets: list[str] = []
    for key, setting in assignment.items():
        component, variable = split_name(key)
        number = _number(composition, key, setting)
        if number is None:
            sets.append(f"{key}={setting}")
        else:
            values.setdefault(component, {})[variable] = number
    return values, tuple(sets)


def _number(composition: Composition, key: str, setting: Setting) -> float | None:
    """Return a setting as the number of a real variable; None if it is another."""
    component, variable = split_name(key)
    if component not in composition.system.components or not variable:
        return None
    if variable in OF_COMPONENT:
        return None
    variable = variable.removeprefix("parameters.").removeprefix("start.")
    part = composition.system.components[component]
    if composition.in_gain(component, variable):
        return None  # the gain changes with it
    described = composition.fmus[component].variables
    theirs = part.map[variable].name if variable in part.map else variable
    if theirs not in described or described[theirs].sort != "real":
        return None
    if not isinstance(setting, str):
        return float(setting)
    try:
        quantity = parse_quantity(setting)
    except ValueError as error:
        raise ScenarioError(f"--vary {key}={setting}: {error}") from None
    if quantity.unit == "1":
        return quantity.value
    return quantity.to(composition.unit(key)).value


def numbers(composition: Composition, full: str) -> set[str]:
    """Return the numbers of FMUs that a name stands for; none if it is another text."""
    owner, name = split_name(full)
    part = composition.system.components.get(owner)
    if part is None:
        return set()
    found = laid.numbers(part, composition.fmus[owner], name)
    return {f"{owner}.{variable}[{element}]" for variable, element in found}


def refuse_driven(composition: Composition, option: str, keys: Iterable[str]) -> None:
    """Raise ``ScenarioError`` if a connection drives what is to be varied."""
    connections = composition.system.connections
    driven = {n: sink for sink in connections for n in numbers(composition, sink)}
    for key in keys:
        for sink in (driven[n] for n in numbers(composition, key) if n in driven):
            raise ScenarioError(
                f"{option} {key}: {connections[sink]} drives it, so that a value set "
                f"is only where the initialisation begins; leave the connection out, "
                f'"{sink}" = false in [connections]'
            )
