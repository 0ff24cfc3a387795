"""What was measured: loops broken at outputs, or what is between inputs and outputs."""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from orchestrator.quantities.unit import UndefinedUnit, Unit, quotient_unit, unit_of
from orchestrator.response.margins import TINY, Margins, margins, peak
from orchestrator.shown import Shown

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

RESOLVED = 0.9
FALLEN = 1 / np.sqrt(2)  # of the gain at the lowest line, where a bandwidth ends


@dataclass(frozen=True, kw_only=True)
class Measured(Shown):
    """At which lines ``hz`` what was excited, and how sure what answers is.

    ``breaks`` are the places that were excited, with their ``units``; ``half`` is the
    largest relative difference at half the ``amplitude``; ``range`` (m, 2) is between
    what values the breaks were without injection, while it was ``measured`` (s);
    ``silent`` says in words where nothing of it arrives.
    """

    breaks: tuple[str, ...]
    units: tuple[str, ...]
    hz: Real
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
    silent: tuple[str, ...] = ()

    @property
    def ended(self) -> Fraction:
        """When (s) it was measured to, exactly."""
        return (self.settled + 1) * self.period

    PAGE = "orchestrator.response.notebook:write_measured"


@dataclass(frozen=True, kw_only=True)
class Response(Measured):
    """L, S, T (lines, m, m) of m breaks.

    ``s_max`` is the largest singular value of S; ``loops`` are the margins of each
    break with the others closed; ``half`` is of S where |S| > 0.3.
    """

    L: Complex
    S: Complex
    T: Complex

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
    def loci(self) -> Complex:
        """The eigenvalues of L (lines, m), each continued from line to line."""
        return eigenvalues(self.L)

    @property
    def together(self) -> tuple[Margins, ...]:
        """The margins of each eigenvalue: of what changes at all breaks alike."""
        return tuple(margins(self.hz, locus) for locus in self.loci.T)

    @property
    def resolved(self) -> bool:
        """Whether the lines beside the largest S are nearly as large."""
        return _resolved(self.singular[:, 0])

    @property
    def s_max(self) -> tuple[float, float]:
        """The largest singular value of S, and where (Hz)."""
        hz, size = peak(self.hz, self.singular[:, 0])
        return size, hz


@dataclass(frozen=True, kw_only=True)
class Transfer(Measured):
    """G (lines, p, m) from m inputs to p ``observed`` signals, in their units."""

    observed: tuple[str, ...]
    observed_units: tuple[str, ...]
    G: Complex

    @property
    def resolved(self) -> bool:
        """Whether the lines beside the largest |G| of each pair are nearly as large.

        What is largest at the lowest line goes on to grow below it.
        """
        size = np.abs(self.G).reshape(len(self.hz), -1)
        inside = (column for column in size.T if np.argmax(column))
        return all(_resolved(column) for column in inside)

    def unit(self, output: int, input: int) -> str:
        """The unit of one of them."""
        above, below = self.observed_units[output], self.units[input]
        ends = unit_of(above).of_difference(), unit_of(below).of_difference()
        try:
            return quotient_unit(*ends)
        except UndefinedUnit:
            return Unit(f"{above}/({below})")

    def peak(self, output: int = 0, input: int = 0) -> tuple[float, float]:
        """The largest |G|, and where (Hz)."""
        hz, size = peak(self.hz, np.abs(self.G[:, output, input]))
        return size, hz

    def bandwidth_hz(self, output: int = 0, input: int = 0) -> float:
        """Where |G| first falls 3 dB below what it is at the lowest line; or never."""
        size = np.log(np.maximum(np.abs(self.G[:, output, input]), 1e-300))
        below = size - size[0] - np.log(FALLEN)
        fallen = np.flatnonzero(below < 0)
        if not len(fallen):
            return np.inf
        i, x = int(fallen[0]), np.log(self.hz)
        share = below[i - 1] / (below[i - 1] - below[i])
        return float(np.exp(x[i - 1] + share * (x[i] - x[i - 1])))


def eigenvalues(L: Complex) -> Complex:
    """Return the eigenvalues of L (lines, m, m), each continued from line to line.

    Generalised Nyquist: det(I + L) is the product of 1 + each, so that a gain or a
    delay common to all breaks takes the loops to their border where it takes one of
    these to -1 (MacFarlane and Postlethwaite 1977).
    """
    found = np.asarray(np.linalg.eigvals(L), dtype=np.complex128)
    for one, after in pairwise(found):
        ratio = np.maximum(np.abs(one[:, None]), TINY) / np.maximum(
            np.abs(after[None, :]), TINY
        )
        turned = np.angle(one[:, None] * after[None, :].conj())
        apart = np.hypot(np.log(ratio), turned)
        after[:] = after[linear_sum_assignment(apart)[1]]
    return found


def _resolved(size: Real) -> bool:
    i = int(np.argmax(size))
    return bool(np.min(size[max(i - 1, 0) : i + 2]) > RESOLVED * size[i])
