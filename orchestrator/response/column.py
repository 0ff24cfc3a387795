"""One place excited: phasors of all that is observed, until they are sure.

Periods are run until all that can answer has, and two agree, or differ by noise alone
(``settling``); with noise or distortion the same lines are excited again with other
phases, twice as often each time, until the mean is sure to ``SURE`` of |S|.  Their
spread is the coherence.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError
from orchestrator.response.bench import FIRST, Bench
from orchestrator.response.excitation import Form, Grid, Lines, folds, signal, spectra
from orchestrator.response.settling import Periods
from orchestrator.response.traced import linked, refuse_growth

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

MOST = 64  # periods of one run
ROUNDS = 8  # times an answer may go round in one run, if these are more periods
LINEAR = 1e-6  # distortion below which one realisation is all
SURE = 0.004  # standard error of S, of its size: 0.035 dB
FAINT = 0.01  # of the largest |Q|: what is smaller need not be as sure
REALISATIONS = 16


class Unanswered(ResponseError):
    """Nothing of what is injected arrives where it is observed."""


@dataclass(frozen=True)
class Column:
    """Q (lines, observed) = -Y/D for one excited place, and how sure it is.

    Of a loop that is T, of which S = 1 - T is to be sure; else Q itself.

    ``distortion`` is what appears where nothing is excited, ``alias`` what at the
    lines onto which slower samples fold, both as shares of the rms at the excited
    ones; ``settled`` periods passed before, ``error`` (lines,) is that of |S| or |Q|.
    """

    Q: Complex
    coherence: Real
    error: Real
    distortion: float
    alias: float
    settled: int
    realisations: int


def column(
    bench: Bench,
    excited: int,
    lines: Grid,
    shape: Real,
    rms: float,
    form: Form,
    most: int = REALISATIONS,
) -> Column:
    """Measure with lines of ``shape`` (lines,) and this ``rms`` at one break.

    Raises:
        ResponseError: the loop does not settle.
        Unanswered: nothing arrives, though by the equations it may.
    """
    if form == "stepped":
        return _stepped(bench, excited, lines, shape, rms)
    generator = np.random.default_rng(1 + excited)
    found: list[_Pass] = []
    wanted = 1
    while len(found) < wanted:
        d = rms * signal(lines.excited, shape, lines.n, form, generator)
        found.append(_pass(bench, excited, lines, d))
        if len(found) == wanted:
            whole = _whole(found, excited if bench.loops else None)
            sure = whole.distortion < LINEAR or np.all(whole.error < SURE)
            if not sure and form == "multisine" and wanted < most:
                wanted *= 2
    return whole


@dataclass(frozen=True)
class _Pass:
    """Phasors of one realisation (lines, observed) and of its injection (lines,)."""

    D: Complex
    B: Complex
    distortion: float
    alias: float
    settled: int


def _pass(bench: Bench, excited: int, lines: Grid, d: Real) -> _Pass:
    given: list[Real | None] = [None] * len(bench.breaks)
    given[excited] = d
    settled = None
    periods = max(bench.periods, FIRST)
    while settled is None:
        values = bench.responses(given, periods)
        found = _periods(bench, values, lines.n)
        bench.periods = periods
        if found.finite and _answered(bench, excited, found):
            settled = found.steady(last=periods >= _most(found.late))
        if settled is None and periods >= _most(found.late):
            refuse_growth(bench, lines.n * bench.rates.T)
            raise ResponseError(_unsettled(bench, excited, found))
        periods *= 2
    values[found.silent] = 0
    rest = values[:, settled * lines.n :]
    slow = bench.rates.slow
    aliased = folds(lines.excited, lines.n, slow) if slow > 1 else lines.excited[:0]
    silent = np.setdiff1d(lines.detecting, aliased)
    judged = rest[[excited]] if bench.loops else rest
    B = np.array([spectra(v, lines.n, lines.excited).mean(axis=0) for v in rest]).T
    return _Pass(
        spectra(d, lines.n, lines.excited)[0],
        B,
        max(_share(v, lines.n, silent, lines.excited) for v in judged),
        max(_share(v, lines.n, aliased, lines.excited) for v in judged),
        settled,
    )


def _share(values: Real, n: int, of: Lines, among: Lines) -> float:
    """Return the rms at some lines as a share of that at others."""
    size = [
        np.sum(np.abs(spectra(values, n, which).mean(axis=0)) ** 2)
        for which in (of, among)
    ]
    return float(np.sqrt(size[0] / size[1])) if size[1] else 0.0


def _periods(bench: Bench, values: Real, n: int) -> Periods:
    shape = len(bench.observed), -1, n
    quiet = bench.twin(n, values.shape[1] // n)
    late = ceil(bench.late.seconds / (n * bench.rates.T))
    return Periods(values.reshape(shape), quiet.reshape(shape), late)


def _most(late: int) -> int:
    return max(MOST, ROUNDS * late)


def _answered(bench: Bench, excited: int, found: Periods) -> bool:
    """Whether all that is observed has answered that may, in the time it may need.

    Raises:
        Unanswered: that time is over, and nothing has.
    """
    if not np.any(found.silent):
        return True
    periods, n = found.values.shape[1:]
    links = linked(bench, periods * n * bench.rates.T)[:, excited]
    if not np.any(found.silent & links):
        return True
    waited = periods >= (found.late + FIRST if bench.late.whole else _most(found.late))
    if waited and np.all(found.silent):
        raise Unanswered(_nothing(bench, excited, found))
    return periods >= found.late + FIRST and not np.all(found.silent)


def _nothing(bench: Bench, excited: int, found: Periods) -> str:
    periods, n = found.values.shape[1:]
    where = ", ".join(name for name, _ in bench.observed)
    return (
        f"{bench.option} {bench.breaks[excited].name}: nothing of what is injected "
        f"arrives at {where} within {periods} periods of "
        f"{float(n * bench.rates.T):g} s; is a gain on the way 0, or the dead time "
        f"longer (give a lower --from), or too little injected for a step of a "
        f"quantiser (give a larger --amplitude)?"
    )


def _unsettled(bench: Bench, excited: int, found: Periods) -> str:
    periods, n = found.values.shape[1:]
    what = "what grows is unstable: look at the signs and sizes of gains"
    if not found.growing:
        what = "it is unstable, or slower than that: give a lower --from"
    return (
        f"{bench.option} {bench.breaks[excited].name}: after {periods} periods of "
        f"{float(n * bench.rates.T):g} s its loop has not settled; {what}"
    )


def _whole(found: list[_Pass], own: int | None) -> Column:
    D = np.array([p.D for p in found])[:, :, None]
    B = np.array([p.B for p in found])
    power = np.sum(np.abs(D) ** 2, axis=0)
    cross = np.sum(B * D.conj(), axis=0)
    Q = -cross / power
    scale = power * np.sum(np.abs(B) ** 2, axis=0)
    coherence = np.divide(
        np.abs(cross) ** 2, scale, out=np.ones(Q.shape), where=scale > 0
    )
    error = np.full(len(Q), np.inf)
    if len(found) > 1:
        spread = np.abs(-B / D - Q) ** 2
        each = np.sqrt(np.sum(spread, axis=0) / (len(found) * (len(found) - 1)))
        error = _relative(each, Q, own)
    return Column(
        Q,
        coherence[:, own] if own is not None else np.min(coherence, axis=1),
        error,
        float(np.mean([p.distortion for p in found])),
        float(np.mean([p.alias for p in found])),
        max(p.settled for p in found),
        len(found),
    )


def _relative(error: Real, Q: Complex, own: int | None) -> Real:
    """Return errors (lines, observed) as shares of |S| of the own loop, or of |Q|.

    No line counts for less than a tenth of 1, or a hundredth of the largest |Q|.
    """
    if own is not None:
        share: Real = error[:, own] / np.maximum(np.abs(1 - Q[:, own]), 0.1)
        return share
    least = FAINT * np.max(np.abs(Q), axis=0)
    size = np.maximum(np.abs(Q), least)
    shares = np.divide(error, size, out=np.zeros(Q.shape), where=size > 0)
    worst: Real = np.max(shares, axis=1)
    return worst


def _stepped(
    bench: Bench, excited: int, lines: Grid, shape: Real, rms: float
) -> Column:
    """Measure one sine at a time; all that is no multiple of it is distortion."""
    size = rms * np.sqrt(2) * shape / np.max(shape)
    everywhere = np.arange(1, lines.n // 2)
    passes = []
    for line, amplitude in zip(lines.excited, size, strict=True):
        one = np.array([line])
        d = amplitude * np.cos(2 * np.pi * line * np.arange(lines.n) / lines.n)
        alone = Grid(lines.n, one, np.setdiff1d(everywhere, one))
        passes.append(_pass(bench, excited, alone, d))
    own = excited if bench.loops else None
    columns = [_whole([p], own) for p in passes]
    return Column(
        np.concatenate([c.Q for c in columns]),
        np.concatenate([c.coherence for c in columns]),
        np.concatenate([c.error for c in columns]),
        max(c.distortion for c in columns),
        max(c.alias for c in columns),
        max(c.settled for c in columns),
        1,
    )
