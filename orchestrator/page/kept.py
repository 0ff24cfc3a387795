"""A composition kept between the positions of a slider, and run for each of them.

What only changes parameters and start values runs on what is kept: as one fused loop
where all FMUs are ours, else with the FMUs loaded.  Anything else (rates, latencies,
gains made of parameters, what a design is told) is composed anew, once.  Rows stay in
memory; their bits are those of a run with the same ``--set``.
"""

from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import numpy as np

from fmus.compile import CompileError
from orchestrator.analysis.members import split
from orchestrator.analysis.variations import Setting
from orchestrator.errors import SimulationError
from orchestrator.evaluation.divergence import divergence
from orchestrator.evaluation.expectation import check
from orchestrator.evaluation.metrics import evaluate
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.groups import only_python
from orchestrator.master.loaded import Loaded
from orchestrator.master.member import Values
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.outcome import Run
from orchestrator.result import End, Recorded, Signal
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import Swaps, load_scenario
from orchestrator.session import naming, refuse_metrics, run_earlier
from orchestrator.warned import collecting

MOST = 6  # compositions that are kept
# instants that are run unasked
LONGEST = {"fused": 3_000_000, "kernel": 500_000, "python": 20_000}


class Passing(Run):
    """A run of which nothing is written: its rows are in memory.

    ``unfinished``: it still goes on, and has no figures yet.
    """

    def __init__(
        self,
        composition: Composition,
        rows: Recorded,
        ended: End | None = None,
        warnings: tuple[str, ...] = (),
        *,
        unfinished: bool = False,
    ) -> None:
        self._rows = rows
        self.timing, self.ended, self.composition = None, ended, composition
        self.number, self.unlike = None, ()
        self.warnings = (*composition.warnings, *warnings)
        self.metrics, self.checks, self.diverged = {}, [], None
        if unfinished:
            return
        spec, parameter = composition.scenario.spec, composition.parameter
        with np.errstate(all="ignore"):  # what diverges may overflow here
            self.metrics = evaluate(spec.metrics, self, parameter, ended)
            self.diverged = divergence(spec.metrics, self, parameter)
        self.checks = check(spec.expected_of_run, self.metrics)

    def at(self, period: Fraction) -> Recorded:  # type: ignore[override]
        return self._rows.at(period)

    def __getitem__(self, name: str) -> Signal:
        return self._rows[name]

    def __contains__(self, name: object) -> bool:
        return name in self._rows

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)


class Kept:
    """A composition with all that its next run needs.

    Raises:
        FeedDriveError, fmus.build.BuildError: as ``run`` would.
    """

    def __init__(
        self, name: str | Path, sets: tuple[str, ...] = (), swaps: Swaps | None = None
    ) -> None:
        scenario = load_scenario(name, sets, swaps)
        with naming(scenario):
            self.composition = compose(scenario, run_earlier)
            refuse_metrics(self.composition)
            self.timetable = plan(self.composition.system)
        tables = self.timetable.wiring.tables
        self._signals = frozenset(c.name for of in tables.values() for c in of)
        self._loaded = Loaded()
        self._series = Series(self.timetable, self._signals, self._loaded)
        self._lanes: Lanes | None = None
        with suppress(SimulationError, CompileError):
            self._lanes = Lanes(self.timetable, self._signals, 1)

    @property
    def executor(self) -> str:
        """What carries out its runs."""
        if self._lanes:
            return "fused"
        return "python" if only_python(self.timetable.wiring) else "kernel"

    @property
    def too_long(self) -> str | None:
        """Say why it is run only when that is asked for; None if it may be unasked."""
        system, tick = self.composition.system, self.timetable.schedule.tick
        instants = system.stop // tick
        if instants <= LONGEST[self.executor]:
            return None
        return (
            f"{float(system.stop):g} s are {instants:,} instants, too many to run "
            f"whenever something is moved; Run and keep shows the curves"
        )

    def run(self, values: Values) -> Passing:
        """Run it with these parameters and start values besides its own.

        Raises:
            FeedDriveError: a value does not fit, or the run failed.
        """
        with naming(self.composition.scenario), collecting() as warnings:
            rows, ended = self._rows(values)
            member = self.composition.with_values(values)
            return Passing(member, rows, ended, tuple(warnings))

    def _rows(self, values: Values) -> tuple[Recorded, End | None]:
        if self._lanes:
            member = next(self._lanes.run([values]))
            if member.failure:
                raise member.failure
            if not member.unsettled:
                return member.signals, None
        return self._series.run(values)

    def close(self) -> None:
        """Free its FMUs."""
        self._loaded.drop()


class Shelf:
    """The compositions that were asked for last."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[Path, tuple[str, ...]], Kept] = OrderedDict()

    def of(self, file: Path, sets: tuple[str, ...] = ()) -> Kept:
        """Return the composition of a scenario with ``sets``, kept or made now."""
        key = file, sets
        if key not in self._kept:
            self._kept[key] = Kept(file, sets)
            while len(self._kept) > MOST:
                self._kept.popitem(last=False)[1].close()
        self._kept.move_to_end(key)
        return self._kept[key]

    def run(self, file: Path, settings: Mapping[str, Setting]) -> Passing | str:
        """Run a scenario with settings, each as ``--set`` takes it; or say why not.

        Raises:
            FeedDriveError, fmus.build.BuildError: it cannot be run, or the run failed.
        """
        values, sets = split(self.of(file).composition, settings)
        kept = self.of(file, sets)
        return kept.too_long or kept.run(values)

    def clear(self) -> None:
        """Forget all: files have changed."""
        for kept in self._kept.values():
            kept.close()
        self._kept.clear()
