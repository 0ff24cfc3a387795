"""The frequency response of a loop: lines, amplitude, shape, then what it says.

1. a first pass with even lines; ``auto`` looks for the amplitude with the least
   distortion, up from a fiftieth of the signal's peak without injection;
2. the lines are made denser where |L| is about 1 and shaped by 1/|S|, so that what
   goes on behind the break is about even;
3. the pass that counts, and one at half its amplitude: a loop that answers otherwise
   then is not linear;
4. all again with a period twice as long, while |S| falls away from its largest value
   to the next line.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError
from orchestrator.response.bench import Bench, bench
from orchestrator.response.column import Column, column
from orchestrator.response.excitation import Form, Grid, grid
from orchestrator.response.margins import Margins, margins, peak
from orchestrator.scenario.compose import Composition
from orchestrator.shown import framed

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

LOWEST = Fraction(1)  # Hz
SHAPED = 30.0  # times the smallest line at most
STEP, STEPS = 4.0, 5  # of amplitudes that are tried
GOOD = 1e-3  # distortion at which no other amplitude is looked for
STEPPED = 40  # lines of a stepped sine
FINER = 4  # times the lowest line is halved for lines closer to the largest S
RESOLVED = 0.9
ROUGH = 0.01  # distortion with which the largest |S| is not worth more lines
LOOKING = 2  # realisations of a pass that only looks


@dataclass(frozen=True)
class Response:
    """L, S, T (lines, m, m) of m breaks at ``hz``, and how they were found.

    ``s_max`` is the largest singular value of S; ``loops`` are the margins of each
    break with the others closed; ``half`` is the largest relative difference of S
    (where |S| > 0.3) at half the amplitude; ``range`` (m, 2) is between what values
    the breaks were without injection.
    """

    breaks: tuple[str, ...]
    units: tuple[str, ...]
    hz: Real
    L: Complex
    S: Complex
    T: Complex
    coherence: Real
    amplitude: tuple[float, ...]
    distortion: float
    alias: float
    half: float
    settled: int
    realisations: int
    error: float
    period: Fraction
    sample: Fraction
    slower: str | None
    range: Real
    measured: tuple[float, float]

    def _repr_html_(self) -> str:
        from orchestrator.report.responded import write_responded
        from orchestrator.response.figures import curves, words

        title, told = ", ".join(self.breaks), list(words(self))
        drawn = curves(self)
        return framed(lambda f: write_responded(title, told, [], drawn, {}, f))

    @property
    def loops(self) -> tuple[Margins, ...]:
        return tuple(
            margins(self.hz, (1 - self.S[:, i, i]) / self.S[:, i, i])
            for i in range(len(self.breaks))
        )

    @property
    def singular(self) -> Real:
        """The singular values of S (lines, m), largest first."""
        return np.asarray(np.linalg.svd(self.S, compute_uv=False), dtype=np.float64)

    @property
    def resolved(self) -> bool:
        """Whether the lines beside the largest S are nearly as large."""
        size = self.singular[:, 0]
        i = int(np.argmax(size))
        beside = size[max(i - 1, 0) : i + 2]
        return bool(np.min(beside) > RESOLVED * size[i])

    @property
    def s_max(self) -> tuple[float, float]:
        """The largest singular value of S, and where (Hz)."""
        hz, size = peak(self.hz, self.singular[:, 0])
        return size, hz


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
        ResponseError: no such loop, or it does not settle.
    """
    with bench(composition, breaks) as at:
        for _ in range(FINER):
            found = _Measurement(at, lowest, form, quick).response(amplitude)
            rough = found.distortion > ROUGH
            if found.resolved or rough or form == "stepped":
                break
            lowest /= 2
    return found


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
        m = len(self._bench.breaks)
        rough = self._grid(None)
        even = np.ones(len(rough.excited))
        sizes = [
            amplitude if amplitude else self._amplitude(i, rough, even)
            for i in range(m)
        ]
        first = [self._column(i, rough, even, sizes[i], LOOKING) for i in range(m)]
        lines = self._grid(self._around_one(first, rough))
        shapes = [self._shape(c.Q[:, i], rough, lines) for i, c in enumerate(first)]
        found = [
            self._column(
                i, lines, shapes[i], sizes[i], LOOKING if self._quick else None
            )
            for i in range(m)
        ]
        Q = np.stack([c.Q for c in found], axis=2)
        S = np.eye(m) - Q
        half = 0.0 if self._quick else self._half(found, lines, shapes, sizes)
        hz = lines.excited / float(self._period)
        rates, breaks = self._bench.rates, self._bench.breaks
        periods = max(c.settled for c in found)
        twin = self._bench.twin(self._n, periods + 1)[:, periods * self._n :]
        return Response(
            tuple(b.name for b in breaks),
            tuple(b.unit for b in breaks),
            hz,
            Q @ np.linalg.inv(S),
            S,
            Q,
            np.stack([c.coherence for c in found], axis=1),
            tuple(sizes),
            max(c.distortion for c in found),
            max(c.alias for c in found),
            half,
            periods,
            max(c.realisations for c in found),
            max(float(np.max(c.error)) for c in found),
            self._period,
            rates.T,
            self._slower(),
            np.stack([twin.min(axis=1), twin.max(axis=1)], axis=1),
            (float(periods * self._period), float((periods + 1) * self._period)),
        )

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
        """
        twin = self._bench.twin(self._n, 1)[i]
        moved = float(np.ptp(twin))
        size = moved / 50 or self._declared(i)
        best = self._column(i, lines, shape, size, 1).distortion
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

    def _declared(self, i: int) -> float:
        """Return a hundredth of what the output's description says of its size."""
        name = self._bench.breaks[i].name
        owner, _, variable = name.partition(".")
        described = self._bench.composition.fmus[owner].variables.get(variable)
        largest = float(described.max or "inf") if described else np.inf
        return largest / 100 if 0 < largest < np.inf else 0.01

    def _around_one(
        self, found: Sequence[Column], lines: Grid
    ) -> tuple[float, float] | None:
        near = [
            line
            for i, c in enumerate(found)
            for line, q in zip(lines.excited, c.Q[:, i], strict=True)
            if 0.25 < abs(q / (1 - q)) < 4
        ]
        return (min(near) / 1.2, max(near) * 1.2) if near else None

    def _shape(self, Q: Complex, rough: Grid, lines: Grid) -> Real:
        S = np.interp(np.log(lines.excited), np.log(rough.excited), np.abs(1 - Q))
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
            S = 1 - c.Q[:, i]
            other = self._column(i, lines, shapes[i], sizes[i] / 2, c.realisations)
            seen = np.abs(S) > 0.3
            apart = np.abs(c.Q[:, i] - other.Q[:, i]) / np.abs(S)
            differences += [float(np.max(apart[seen]))] if np.any(seen) else []
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
