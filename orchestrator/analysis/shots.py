"""Quick looks at candidates: their figures, and margins by one fixed injection.

What is injected is that of a full measurement of the scenario as it stands: its
lines, amplitude and shape, with periods down to a quarter as long.  A candidate is
run with it and without, in lanes where all FMUs are ours: two periods to settle, one
measured.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.compile import CompileError
from orchestrator.analysis.width import width
from orchestrator.errors import FeedDriveError, SimulationError
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.loaded import Loaded
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.response.bench import Bench
from orchestrator.response.excitation import Lines, grid, signal, spectra
from orchestrator.response.margins import Margins, margins
from orchestrator.response.measure import Response
from orchestrator.scenario.compose import Composition
from orchestrator.system import System, Value

Real = NDArray[np.float64]
Values = Mapping[str, Mapping[str, Value]]

SHORTER = 4  # times a period is shorter than that of the full measurement at most
SPACED = 30.0  # periods of where |S| is largest in one: lines at a fifteenth of it
SETTLING = 2  # periods
UNSETTLED = 0.02  # of a period's rms, from the one before: not stable


@dataclass(frozen=True)
class Shot:
    """One loop of a candidate: its margins, or by how much it does not settle."""

    margins: Margins | None
    growth: float = 0.0

    def figure(self, name: str) -> float:
        """Return a margin; of a loop that does not settle none is left."""
        if self.margins is None:
            return np.inf if name == "s_max" else -self.growth
        return float(getattr(self.margins, name))


class Shots:
    """Takes shots of one response of a composition, for many candidates."""

    def __init__(self, composition: Composition, full: Response) -> None:
        self._loaded = Loaded()
        bench = Bench(composition, full.breaks, self._loaded)
        rates = bench.rates
        whole = int(rates.whole / rates.T)
        periods = max(float(full.period) / SHORTER, SPACED / full.s_max[1])
        fewest = min(periods, float(full.period)) / float(rates.T)
        self._n = max(1, round(fewest / whole)) * whole
        self._T, self._name = rates.T, bench.breaks[0].name
        chosen = grid(self._n, rates.slow, np.random.default_rng(7), None)
        dense = self._dense(full)
        self._lines: Lines = (
            grid(self._n, rates.slow, np.random.default_rng(7), dense).excited
            if dense
            else chosen.excited
        )
        self._hz = self._lines / float(self._n * rates.T)
        size = np.abs(full.S[:, 0, 0])
        S = np.interp(np.log(self._hz), np.log(full.hz), size)
        shape = 1 / np.maximum(S, np.max(S) / 30)
        d = full.amplitude[0] * signal(
            self._lines, shape, self._n, "multisine", np.random.default_rng(1)
        )
        self._D = spectra(d, self._n, self._lines)[0]
        periods = SETTLING + 1
        system = bench.system([d], self._n, periods)
        self._with = _Runs(system, self._name, self._loaded)
        self._without = _Runs(replace(system, injections={}), self._name, self._loaded)

    def _dense(self, full: Response) -> tuple[float, float] | None:
        size = np.abs(full.L[:, 0, 0])
        near = full.hz[(size > 0.1) & (size < 10)] * float(self._n * self._T)
        return (near[0] / 2, near[-1] * 2) if len(near) else None

    def take(self, members: Sequence[Values]) -> list[Shot]:
        """Return the shot of every member."""
        pairs = zip(self._with.run(members), self._without.run(members), strict=True)
        return [self._shot(*pair) for pair in pairs]

    def _shot(self, excited: Real | None, quiet: Real | None) -> Shot:
        n, rows = self._n, (SETTLING + 1) * self._n
        if excited is None or quiet is None:
            return Shot(None, 1e3)
        moved = (excited - quiet)[:rows].reshape(-1, n)
        if not np.max(np.abs(moved)) < 1e50:
            return Shot(None, 1e3)
        size = np.sqrt(np.mean(moved[-1] ** 2))
        apart = np.sqrt(np.mean((moved[-1] - moved[-2]) ** 2))
        if apart > UNSETTLED * size:
            return Shot(
                None, 1 + float(np.log10(1 + size / np.sqrt(np.mean(moved[0] ** 2))))
            )
        B = spectra(moved[-1], n, self._lines)[0]
        return Shot(margins(self._hz, -B / (B + self._D)))

    def close(self) -> None:
        """Free the FMUs that did not run in lanes."""
        self._loaded.drop()


class _Runs:
    """Runs of one system: a recorded signal of each member, None where it failed."""

    def __init__(self, system: System, name: str, loaded: Loaded) -> None:
        self._timetable, self._name, self._loaded = plan(system), name, loaded
        self._lanes: Any = None
        with suppress(SimulationError, CompileError):
            self._lanes = Lanes(self._timetable, frozenset({name}), width())

    def run(self, members: Sequence[Values]) -> Iterator[Real | None]:
        """Yield the signal of every member."""
        if self._lanes is None:
            yield from (self._alone(member) for member in members)
            return
        for member, values in zip(self._lanes.run(members), members, strict=True):
            if member.unsettled:
                yield self._alone(values)
            else:
                failed = member.failure is not None
                yield None if failed else member.signals[self._name].values

    def _alone(self, member: Values) -> Real | None:
        series = Series(self._timetable, frozenset({self._name}), self._loaded)
        try:
            return series.run(member)[0][self._name].values
        except FeedDriveError:
            return None
