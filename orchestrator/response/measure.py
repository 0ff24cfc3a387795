"""The frequency response of a loop, or from inputs to outputs, carried out.

1. a first pass with even lines; ``auto`` looks for the amplitude with the least
   distortion, up from a fiftieth of the signal's peak without injection;
2. the lines are made denser where |L| is about 1, or |G| largest, and shaped by 1/|S|
   or 1/|G|, so that what goes on behind the break is about even;
3. the pass that counts, and one at half its amplitude: what answers otherwise then is
   not linear;
4. all again with a period twice as long, while |S| or |G| falls away from its largest
   value to the next line.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError
from orchestrator.response.bench import Bench, bench
from orchestrator.response.column import Column, Unanswered, column
from orchestrator.response.excitation import Form, Grid, grid
from orchestrator.response.measured import Response, Transfer
from orchestrator.response.traced import linked, refuse_growth
from orchestrator.scenario.compose import Composition

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
M = TypeVar("M", Response, Transfer)

LOWEST = Fraction(1)  # Hz
SHAPED = 30.0  # times the smallest line at most
MOVED = 1e-2  # of how far a signal moves anyway
STEP, STEPS = 4.0, 5  # of amplitudes that are tried
GOOD = 1e-3  # distortion at which no other amplitude is looked for
STEPPED = 40  # lines of a stepped sine
FINER = 4  # times the lowest line is halved for lines closer to the largest S
SEEN = 0.3  # |S| from which on a difference at half the amplitude counts
LOUD = 0.05  # of the largest |G|, likewise
ROUGH = 0.01  # distortion with which the largest |S| is not worth more lines
LOOKING = 2  # realisations of a pass that only looks


def measure(
    composition: Composition,
    breaks: Sequence[str],
    *,
    amplitude: float | None = None,
    lowest: Fraction = LOWEST,
    form: Form = "multisine",
    quick: bool = False,
) -> Response:
    """Measure the loop that is broken at outputs, ``component.output``.

    ``amplitude`` is the rms of what is injected, in the unit of the break, chosen
    if None; ``lowest`` (Hz) the lowest line.  ``quick`` leaves out half the amplitude
    and repetitions.

    Raises:
        ResponseError: no such loop, it does not settle or is unstable by its
            equations, or nothing of what is injected comes back.
    """
    with bench(composition, breaks) as at:
        return _resolved(
            at,
            lowest,
            form,
            lambda low: _Measurement(at, low, form, quick).response(amplitude),
        )


def measure_transfer(
    composition: Composition,
    excited: Sequence[str],
    observed: Sequence[str],
    *,
    amplitude: float | None = None,
    lowest: Fraction = LOWEST,
    form: Form = "multisine",
    quick: bool = False,
) -> Transfer:
    """Measure from inputs (or outputs, with all they drive) to any signals.

    The loops of the composition stay closed; what is injected is added to what the
    input is given anyway.  Options as of ``measure``; ``amplitude`` is in the unit of
    each input.

    Raises:
        ResponseError: no such signals, no way between them, it does not settle or is
            unstable by its equations, or nothing of what is injected arrives.
    """
    with bench(composition, excited, observed) as at:
        return _resolved(
            at,
            lowest,
            form,
            lambda low: _Measurement(at, low, form, quick).transfer(amplitude),
        )


def _resolved(
    at: Bench, lowest: Fraction, form: Form, measured: Callable[[Fraction], M]
) -> M:
    """Measure with lower and lower lines until the largest value is resolved."""
    for _ in range(FINER):
        found = measured(lowest)
        if found.resolved or found.distortion > ROUGH or form == "stepped":
            break
        lowest /= 2
    refuse_growth(at, found.ended)
    return found


@dataclass(frozen=True)
class _Columns:
    """What the passes that count found, one of each place that was excited."""

    lines: Grid
    found: list[Column]
    sizes: list[float]
    half: float


class _Measurement:
    def __init__(self, at: Bench, lowest: Fraction, form: Form, quick: bool) -> None:
        self._bench, self._form, self._quick = at, form, quick
        rates = at.rates
        self._period = ceil(1 / lowest / rates.whole) * rates.whole
        self._n = int(self._period / rates.T)
        if self._n < 32:
            raise ResponseError(
                f"the lowest line, {float(lowest):g} Hz, leaves {self._n} samples of "
                f"{float(rates.T):g} s in a period; give a lower --from"
            )

    def response(self, amplitude: float | None) -> Response:
        """Return L, S and T of the loops."""
        columns = self._columns(amplitude)
        Q = np.stack([c.Q for c in columns.found], axis=2)
        S = np.eye(Q.shape[1]) - Q
        return Response(L=Q @ np.linalg.inv(S), S=S, T=Q, **self._told(columns))

    def transfer(self, amplitude: float | None) -> Transfer:
        """Return G from what is excited to what is observed."""
        columns = self._columns(amplitude)
        return Transfer(
            observed=tuple(name for name, _ in self._bench.observed),
            observed_units=tuple(unit for _, unit in self._bench.observed),
            G=-np.stack([c.Q for c in columns.found], axis=2),
            **self._told(columns),
        )

    def _columns(self, amplitude: float | None) -> _Columns:
        m = len(self._bench.breaks)
        rough = self._grid(None)
        even = np.ones(len(rough.excited))
        sizes = [
            amplitude if amplitude else self._amplitude(i, rough, even)
            for i in range(m)
        ]
        first = [self._column(i, rough, even, sizes[i], LOOKING) for i in range(m)]
        lines = self._grid(self._dense(first, rough))
        shapes = [
            self._shape(self._size(c, i), rough, lines) for i, c in enumerate(first)
        ]
        most = LOOKING if self._quick else None
        found = [self._column(i, lines, shapes[i], sizes[i], most) for i in range(m)]
        half = 0.0 if self._quick else self._half(found, lines, shapes, sizes)
        return _Columns(lines, found, sizes, half)

    def _told(self, columns: _Columns) -> dict[str, Any]:
        found, at = columns.found, self._bench
        periods = max(c.settled for c in found)
        level = at.levels(self._n, periods + 1)[:, periods * self._n :]
        return {
            "breaks": tuple(b.name for b in at.breaks),
            "units": tuple(b.unit for b in at.breaks),
            "hz": columns.lines.excited / float(self._period),
            "coherence": np.stack([c.coherence for c in found], axis=1),
            "amplitude": tuple(columns.sizes),
            "distortion": max(c.distortion for c in found),
            "alias": max(c.alias for c in found),
            "half": columns.half,
            "settled": periods,
            "realisations": max(c.realisations for c in found),
            "error": max(float(np.max(c.error)) for c in found),
            "period": self._period,
            "sample": at.rates.T,
            "slower": self._slower(),
            "range": np.stack([level.min(axis=1), level.max(axis=1)], axis=1),
            "measured": (
                float(periods * self._period),
                float((periods + 1) * self._period),
            ),
            "silent": tuple(self._silent(found)),
        }

    def _silent(self, found: Sequence[Column]) -> Iterator[str]:
        """Yield where nothing of what is injected arrives, in words."""
        at = self._bench
        for j, c in enumerate(found):
            for i in np.flatnonzero(np.all(c.Q == 0, axis=0)):
                why = (
                    f"within {at.periods} periods of {float(self._period):g} s"
                    if linked(at, self._period)[i, j]
                    else "and by the models' equations nothing can"
                )
                yield (
                    f"nothing of what is injected at {at.breaks[j].name} arrives at "
                    f"{at.observed[i][0]}, {why}: it is 0 there"
                )

    def _size(self, c: Column, i: int) -> Real:
        """Return how large what is to be sure is: |S|, or the largest share of |G|."""
        if self._bench.loops:
            return np.abs(1 - c.Q[:, i])
        most = np.max(np.abs(c.Q), axis=0)
        shares = np.divide(np.abs(c.Q), most, out=np.zeros(c.Q.shape), where=most > 0)
        size: Real = np.max(shares, axis=1)
        return size

    def _grid(self, dense: tuple[float, float] | None) -> Grid:
        generator = np.random.default_rng(7)
        found = grid(self._n, self._bench.rates.slow, generator, dense)
        if self._form == "stepped":
            every = max(1, len(found.excited) // STEPPED)
            return Grid(found.n, found.excited[::every], found.detecting)
        return found

    def _column(
        self, i: int, lines: Grid, shape: Real, rms: float, most: int | None = None
    ) -> Column:
        if most is None:
            return column(self._bench, i, lines, shape, rms, self._form)
        return column(self._bench, i, lines, shape, rms, self._form, most)

    def _amplitude(self, i: int, lines: Grid, shape: Real) -> float:
        """Return the amplitude with the least distortion, from a small one upwards.

        None is larger than the range of the signal without injection, if it moves.
        Of one that does not, what is observed is to move a little more than anyway.
        """
        moved = float(np.ptp(self._bench.levels(self._n, 1)[i]))
        size = moved / 50 or self._declared(i)
        size, first = self._heard(i, lines, shape, size, moved)
        if not moved and not self._bench.loops:
            size *= self._more(first, size)
            first = self._column(i, lines, shape, size, 1)
        best = first.distortion
        for factor in (STEP, 1 / STEP):
            tried, steps = size, 0
            while best > GOOD and steps < STEPS:
                tried, steps = tried * factor, steps + 1
                if moved and tried > moved:
                    break
                now = self._column(i, lines, shape, tried, 1).distortion
                if now > best / 1.2:
                    break
                size, best = tried, now
        return size

    def _heard(
        self, i: int, lines: Grid, shape: Real, size: float, most: float
    ) -> tuple[float, Column]:
        """Return the first amplitude that is answered, and what that is.

        What is less than a step of a quantiser has no answer.
        """
        for _ in range(STEPS):
            try:
                return size, self._column(i, lines, shape, size, 1)
            except Unanswered:
                if most and STEP * size > most:
                    raise
            size *= STEP
        return size, self._column(i, lines, shape, size, 1)

    def _more(self, first: Column, rms: float) -> float:
        """Return how many times more makes something observed move by ``MOVED``."""
        answered = rms * np.sqrt(np.mean(np.abs(first.Q) ** 2, axis=0))
        wanted = MOVED * np.ptp(self._bench.twin(self._n, 1), axis=1)
        seen = (answered > 0) & (wanted > 0)
        return float(np.min(wanted[seen] / answered[seen])) if np.any(seen) else 1.0

    def _declared(self, i: int) -> float:
        """Return a hundredth of what the output's description says of its size."""
        name = self._bench.breaks[i].name
        owner, _, variable = name.partition(".")
        described = self._bench.composition.fmus[owner].variables.get(variable)
        largest = float(described.max or "inf") if described else np.inf
        return largest / 100 if 0 < largest < np.inf else 0.01

    def _dense(
        self, found: Sequence[Column], lines: Grid
    ) -> tuple[float, float] | None:
        """Return the lines between which |L| is about 1, or |G| large."""
        near: list[int] = []
        for i, c in enumerate(found):
            if self._bench.loops:
                size = np.abs(c.Q[:, i] / (1 - c.Q[:, i]))
                here = (size > 0.25) & (size < 4)
            else:
                here = self._size(c, i) > 0.5
            near += lines.excited[here].tolist()
        return (min(near) / 1.2, max(near) * 1.2) if near else None

    def _shape(self, size: Real, rough: Grid, lines: Grid) -> Real:
        S = np.interp(np.log(lines.excited), np.log(rough.excited), size)
        shape: Real = 1 / np.maximum(S, np.max(S) / SHAPED)
        return shape

    def _half(
        self,
        found: Sequence[Column],
        lines: Grid,
        shapes: Sequence[Real],
        sizes: Sequence[float],
    ) -> float:
        differences = [0.0]
        for i, c in enumerate(found):
            other = self._column(i, lines, shapes[i], sizes[i] / 2, c.realisations)
            difference = np.abs(c.Q - other.Q)
            size, least = np.abs(c.Q), LOUD * np.max(np.abs(c.Q), axis=0)
            if self._bench.loops:
                difference, least = difference[:, [i]], np.array([SEEN])
                size = np.abs(1 - c.Q[:, [i]])
            seen = (size > least) & (size > 0)
            differences += (difference[seen] / size[seen]).tolist()
        return max(differences)

    def _slower(self) -> str | None:
        """Return an output of the slowest component in the loop if it is slower."""
        rates, system = self._bench.rates, self._bench.composition.system
        if rates.slow == 1:
            return None
        for name in rates.slowest:
            for source in system.connections.values():
                if source.startswith(f"{name}."):
                    return source
        return None
