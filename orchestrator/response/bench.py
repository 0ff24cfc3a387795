"""A composition that is excited somewhere and observed somewhere.

Runs go on past the scenario's stop for as many periods as are asked for; the same
run without injection is subtracted, in motion too.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError, SimulationError
from orchestrator.master.loaded import Loaded
from orchestrator.master.schedule import rational_gcd
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.response.late import lateness
from orchestrator.response.places import (
    broken_at,
    excited_at,
    observed_at,
    rates_of_loops,
    rates_of_ways,
)
from orchestrator.scenario.compose import Composition
from orchestrator.system import Injection, System

FIRST = 4  # periods of the first run

Real = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Bench:
    """Runs a composition with signals injected at its breaks, or at its inputs.

    ``observed`` None: loops, broken and observed at the outputs ``names``; else what
    is between the inputs (or outputs) ``names`` and the signals ``observed``.
    """

    def __init__(
        self,
        composition: Composition,
        names: Sequence[str],
        loaded: Loaded,
        observed: Sequence[str] | None = None,
    ) -> None:
        self.composition, self._loaded = composition, loaded
        self.loops = observed is None
        at = broken_at if observed is None else excited_at
        self.breaks = tuple(b for name in names for b in at(composition, name))
        if observed is None:
            self.observed = tuple((b.name, b.unit) for b in self.breaks)
            self.rates = rates_of_loops(composition.system, self.breaks)
        else:
            self.observed = tuple(
                o for name in observed for o in observed_at(composition, name)
            )
            seen = [name for name, _ in self.observed]
            self.rates = rates_of_ways(composition.system, self.breaks, seen)
        self.option = "break" if self.loops else "excite"
        self.late = lateness(composition, self.rates)
        self.links: Bools | None = None  # (observed, breaks), once ``linked`` says it
        self._names = tuple(
            dict.fromkeys(
                [*(n for n, _ in self.observed), *(b.name for b in self.breaks)]
            )
        )
        owner = self.breaks[0].clock
        self._offset = composition.system.components[owner].offset
        self._row = rational_gcd(self.rates.T, self._offset or self.rates.T)
        self._twin: dict[int, Real] = {}
        self.periods = FIRST  # as many as the last run needed

    def responses(self, values: Sequence[Real | None], periods: int) -> Real:
        """Return (observed, periods * n) of what is observed more than unexcited.

        ``values`` (n,) are injected at each break, again and again; None nothing.
        """
        n = next(len(v) for v in values if v is not None)
        m = len(self.observed)
        return self._run(values, n, periods)[:m] - self.twin(n, periods)

    def twin(self, n: int, periods: int) -> Real:
        """Return (observed, periods * n) of what is observed with no injection."""
        return self._unexcited(n, periods)[: len(self.observed)]

    def levels(self, n: int, periods: int) -> Real:
        """Return (breaks, periods * n) of what the breaks are with no injection."""
        rows = [self._names.index(b.name) for b in self.breaks]
        return self._unexcited(n, periods)[rows]

    def _unexcited(self, n: int, periods: int) -> Real:
        rows = periods * n
        known = max(self._twin, default=0)
        if known < rows:
            self._twin = {rows: self._run([None] * len(self.breaks), n, periods)}
            known = rows
        return self._twin[known][:, :rows]

    def system(self, values: Sequence[Real | None], n: int, periods: int) -> System:
        """Return the composition with these injections, recorded whenever they act."""
        injections: dict[str, Injection] = {}
        for broken, given in zip(self.breaks, values, strict=True):
            if given is not None:
                for sink, gain in broken.sinks:
                    injections[sink] = Injection(tuple((gain * given).tolist()))
        return replace(
            self.composition.system,
            stop=self._offset + periods * n * self.rates.T,
            record={name: (self._row,) for name in self._names},
            injections=injections,
        )

    def _run(self, values: Sequence[Real | None], n: int, periods: int) -> Real:
        system = self.system(values, n, periods)
        series = Series(plan(system), frozenset(self._names), self._loaded)
        try:
            found, ended = series.run({})
        except SimulationError as error:
            raise ResponseError(
                f"a run of {float(system.stop):g} s failed, so its loop may be "
                f"unstable: {error}"
            ) from error
        if ended is not None:
            raise ResponseError(f"a run was {ended}; a response needs all its periods")
        return np.array(
            [self.published(found[name].values, periods * n) for name in self._names]
        )

    def published(self, values: Real, rows: int) -> Real:
        """Return the first rows of a record at which something is injected."""
        first, every = int(self._offset / self._row), int(self.rates.T / self._row)
        return values[..., first : first + rows * every : every]


@contextmanager
def bench(
    composition: Composition,
    names: Sequence[str],
    observed: Sequence[str] | None = None,
) -> Iterator[Bench]:
    """Give a composition excited and observed there, its FMUs kept loaded.

    Raises:
        ResponseError: as of ``broken_at``, ``excited_at`` and ``observed_at``.
    """
    loaded = Loaded()
    try:
        yield Bench(composition, names, loaded, observed)
    finally:
        loaded.drop()
