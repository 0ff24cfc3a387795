"""The members of a sweep, carried out: in lanes, or with the FMUs kept loaded.

Members whose settings change more than parameters and start values (rates,
latencies, FMUs, designs, the stop) have a composition of their own; the others
share one.  A composition whose FMUs are all ours runs in lanes on all cores;
any other in processes and libraries that stay loaded, one per core.  A design is
told the nominal values, whatever is varied, unless ``design.*`` itself is.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice

from fmus.compile import CompileError
from orchestrator.analysis.variations import Assignment, Setting
from orchestrator.errors import FeedDriveError, ScenarioError, SimulationError
from orchestrator.evaluation.expectation import Check, check
from orchestrator.evaluation.metrics import evaluate
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.quantities.quantity import Quantity, parse_quantity
from orchestrator.result import Recorded
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.override import OF_COMPONENT
from orchestrator.system import Value, split_name

AHEAD = 3  # batches given to each core before one is taken back
SMALL = 4  # members that a loaded system runs in one batch
MANY = 32  # members from which on the seconds of compiling lanes are won back


@dataclass(frozen=True)
class Outcome:
    """What came of a member: its figures and checks, or why there are none."""

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


def lanes_here() -> int:
    """Return how many lanes a vector of this processor has, times two to four.

    Twice the width of its registers was the fastest measured: with 512 bits
    W = 16, with 256 bits W = 8.
    """
    from pathlib import Path

    info = Path("/proc/cpuinfo")
    flags = info.read_text().split() if info.is_file() else []
    if "avx512f" in flags:
        return 16
    return 8 if "avx2" in flags else 4


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


class Group:
    """Members of one composition, of which ``count`` are to come."""

    def __init__(self, composition: Composition, count: int = 1) -> None:
        self.composition = composition
        self._timetable = plan(composition.system)
        spec = composition.scenario.spec
        self._signals = frozenset(
            s for m in spec.metrics.values() for s in m.signals().values()
        )
        self.executor = "kernel"
        if count >= MANY:
            with suppress(SimulationError, CompileError):
                self._lanes = Lanes(self._timetable, self._signals, lanes_here())
                self.executor = "lanes"

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """Yield the outcome of every job, in order."""
        work = self._in_lanes if self.executor == "lanes" else self._loaded
        size = 2 * lanes_here() if self.executor == "lanes" else SMALL
        batches = iter([jobs[i : i + size] for i in range(0, len(jobs), size)])
        with ThreadPoolExecutor(cores()) as pool:
            waiting: list[Future[list[Outcome]]] = []
            try:
                for batch in islice(batches, AHEAD * cores()):
                    waiting.append(pool.submit(work, batch))
                while waiting:
                    yield from waiting.pop(0).result()
                    for batch in islice(batches, 1):
                        waiting.append(pool.submit(work, batch))
            finally:
                for future in waiting:
                    future.cancel()

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
        found += self._loaded(alone) if alone else []
        return sorted(found, key=lambda outcome: outcome.index)

    def _loaded(self, jobs: Sequence[Job]) -> list[Outcome]:
        found = []
        with Series(self._timetable, self._signals) as series:
            for job in jobs:
                try:
                    found.append(self._evaluated(job, series.run(job.values)))
                except FeedDriveError as error:
                    found.append(Outcome(job.index, {}, failure=str(error)))
        return found

    def _evaluated(self, job: Job, signals: Recorded) -> Outcome:
        spec = self.composition.scenario.spec

        def parameter(name: str) -> Quantity:
            component, variable = split_name(name)
            own = self.composition.parameter(name)
            given = job.values.get(component, {}).get(variable)
            if given is None or isinstance(given, tuple | str):
                return own
            return Quantity(float(given), own.unit)

        try:
            figures = evaluate(spec.metrics, signals, parameter)
            return Outcome(job.index, figures, check(spec.expect, figures))
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
