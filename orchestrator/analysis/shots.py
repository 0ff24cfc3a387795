"""Quick looks at candidates: their figures, and margins by one fixed injection.

What is injected is that of a full measurement of the scenario as it stands: its
lines, amplitude and shape, with periods down to a quarter as long.  A candidate is
run with it, at each break by itself, and without, in lanes where all FMUs are ours:
two periods to settle, one measured.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
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
from orchestrator.response.figures import worst
from orchestrator.response.margins import Margins, margins, peak
from orchestrator.response.measured import Response, eigenvalues
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
    """Loops of a candidate: their figures, or by how much they do not settle."""

    figures: Mapping[str, float] | None
    growth: float = 0.0

    def figure(self, name: str) -> float:
        """Return a margin; of a loop that does not settle none is left."""
        if self.figures is None:
            return np.inf if name == "s_max" else -self.growth
        return self.figures[name]


class Shots:
    """Takes shots of one response of a composition, for many candidates."""

    def __init__(self, composition: Composition, full: Response) -> None:
        self._loaded = Loaded()
        self._bench = Bench(composition, full.breaks, self._loaded)
        rates = self._bench.rates
        whole = int(rates.whole / rates.T)
        periods = max(float(full.period) / SHORTER, SPACED / full.s_max[1])
        fewest = min(periods, float(full.period)) / float(rates.T)
        self._n = max(1, round(fewest / whole)) * whole
        self._T = rates.T
        dense = self._dense(full)
        generator = np.random.default_rng(7)
        self._lines: Lines = grid(self._n, rates.slow, generator, dense).excited
        self._hz = self._lines / float(self._n * rates.T)
        injected = [self._injected(full, i) for i in range(len(full.breaks))]
        self._D = [spectra(d, self._n, self._lines)[0] for d in injected]
        # zeros too are injected: so all runs are of one program, compiled once
        nothing = [np.zeros(self._n)] * len(injected)
        self._runs = [self._of(nothing)]
        for i, d in enumerate(injected):
            self._runs.append(self._of([*nothing[:i], d, *nothing[i + 1 :]]))

    def _injected(self, full: Response, i: int) -> Real:
        size = np.abs(full.S[:, i, i])
        S = np.interp(np.log(self._hz), np.log(full.hz), size)
        shape = 1 / np.maximum(S, np.max(S) / 30)
        generator = np.random.default_rng(1 + i)
        d = signal(self._lines, shape, self._n, "multisine", generator)
        return full.amplitude[i] * d

    def _of(self, injected: Sequence[Real]) -> "_Runs":
        system = self._bench.system(injected, self._n, SETTLING + 1)
        names = tuple(b.name for b in self._bench.breaks)
        return _Runs(system, names, self._loaded)

    def _dense(self, full: Response) -> tuple[float, float] | None:
        S = np.abs(np.diagonal(full.S, axis1=1, axis2=2))
        T = np.abs(np.diagonal(full.T, axis1=1, axis2=2))
        here = np.any((T > 0.1 * S) & (T < 10 * S), axis=1)
        near = full.hz[here] * float(self._n * self._T)
        return (near[0] / 2, near[-1] * 2) if len(near) else None

    def take(self, members: Sequence[Values]) -> list[Shot]:
        """Return the shot of every member."""
        found = zip(*(runs.run(members) for runs in self._runs), strict=True)
        return [self._shot(quiet, excited) for quiet, *excited in found]

    def _shot(self, quiet: Real | None, excited: Sequence[Real | None]) -> Shot:
        n, rows = self._n, (SETTLING + 1) * self._n
        G = []
        for i, one in enumerate(excited):
            if one is None or quiet is None:
                return Shot(None, 1e3)
            moved = self._bench.published(one - quiet, rows)
            moved = moved.reshape(len(one), -1, n)
            if not np.max(np.abs(moved)) < 1e50:
                return Shot(None, 1e3)
            size = np.sqrt(np.mean(moved**2, axis=2))
            apart = np.sqrt(np.mean((moved[:, -1] - moved[:, -2]) ** 2, axis=1))
            if apart[i] > UNSETTLED * size[i, -1]:
                grown = float(np.log10(1 + size[i, -1] / size[i, 0]))
                return Shot(None, 1 + grown)
            B = [spectra(of_one[-1], n, self._lines)[0] for of_one in moved]
            G.append(np.array(B).T / self._D[i][:, None])
        S = np.eye(len(G)) + np.stack(G, axis=2)
        loops = [margins(self._hz, 1 / S[:, i, i] - 1) for i in range(len(G))]
        alike: list[Margins] = []
        if len(G) > 1:
            L = np.asarray(np.linalg.inv(S) - np.eye(len(G)), dtype=np.complex128)
            alike = [margins(self._hz, locus) for locus in eigenvalues(L).T]
        largest = np.linalg.norm(S, 2, axis=(1, 2))
        return Shot(worst(loops, alike, peak(self._hz, largest)[1]))

    def close(self) -> None:
        """Free the FMUs that did not run in lanes."""
        self._loaded.drop()


class _Runs:
    """Runs of one system: recorded signals of each member, None where it failed."""

    def __init__(self, system: System, names: Sequence[str], loaded: Loaded) -> None:
        self._timetable, self._names, self._loaded = plan(system), names, loaded
        self._lanes: Any = None
        with suppress(SimulationError, CompileError):
            self._lanes = Lanes(self._timetable, frozenset(names), width())

    def run(self, members: Sequence[Values]) -> Iterator[Real | None]:
        """Yield the signals (names, rows) of every member."""
        if self._lanes is None:
            yield from (self._alone(member) for member in members)
            return
        for member, values in zip(self._lanes.run(members), members, strict=True):
            if member.unsettled:
                yield self._alone(values)
            else:
                failed = member.failure is not None
                yield None if failed else self._rows(member.signals)

    def _alone(self, member: Values) -> Real | None:
        series = Series(self._timetable, frozenset(self._names), self._loaded)
        try:
            return self._rows(series.run(member)[0])
        except FeedDriveError:
            return None

    def _rows(self, signals: Any) -> Real:
        return np.array([signals[name].values for name in self._names])
