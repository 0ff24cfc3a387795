"""What is injected: odd lines of a period, some left out to see distortion.

A multisine of n samples has lines l = 1 ... n/2 at l/(n T).  Only odd ones are
excited, spread evenly over log f; of each four neighbours that could be, one is left
out at random: what a smooth nonlinearity makes of the others appears there and in
the even lines.  Where a loop has slower samples, lines are taken whose folds about
the slow rate all differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Lines: TypeAlias = NDArray[np.int64]
Real: TypeAlias = NDArray[np.float64]
Form: TypeAlias = Literal["multisine", "chirp", "stepped"]

LINES = 240  # spread over log f; as many again where |L| is about 1
HIGHEST = 0.96  # of half the sampling rate


@dataclass(frozen=True)
class Grid:
    """Lines of a period of ``n`` samples: excited, and where distortion is read."""

    n: int
    excited: Lines
    detecting: Lines


def grid(
    n: int, slow: int, generator: np.random.Generator, dense: tuple[float, float] | None
) -> Grid:
    """Return the lines; ``slow`` samples are one of the slowest in the loop.

    ``dense`` are the lines between which as many again are taken.
    """
    odd = np.arange(1, int(HIGHEST * n / 2), 2)
    left_out = np.zeros(len(odd), bool)
    for first in range(4, len(odd), 4):
        left_out[first + generator.integers(min(4, len(odd) - first))] = True
    possible = odd[~left_out]
    chosen = {int(possible[0])} | _nearest(possible, np.geomspace(1, odd[-1], LINES))
    if dense:
        between = possible[(possible >= dense[0]) & (possible <= dense[1])]
        chosen |= {int(v) for v in between[:: max(1, len(between) // LINES)]}
    excited = np.array(sorted(chosen))
    if slow > 1:
        excited = _unfolded(excited, n // slow)
    even = np.arange(2, int(HIGHEST * n / 2), 2)
    detecting = np.concatenate([odd[left_out], even])
    return Grid(n, excited, np.sort(detecting))


def _nearest(possible: Lines, wanted: Real) -> set[int]:
    at = np.searchsorted(possible, wanted).clip(max=len(possible) - 1)
    return {int(v) for v in possible[at]}


def _unfolded(lines: Lines, turn: int) -> Lines:
    """Return the lines no two of which fold onto each other, low ones first."""
    taken, kept = set(), []
    for line in lines:
        fold = min(line % turn, turn - line % turn)
        if fold not in taken and fold:
            taken.add(fold)
            kept.append(line)
    return np.array(kept)


def folds(lines: Lines, n: int, slow: int) -> Lines:
    """Return the lines below n/2 onto which others fold, without themselves."""
    turn, found = n // slow, set()
    for line in lines:
        for m in range(slow + 1):
            found |= {abs(m * turn - line), m * turn + line}
    below = {v for v in found if 0 < v <= n // 2} - {int(v) for v in lines}
    return np.array(sorted(below), dtype=np.int64)


def signal(
    lines: Lines, shape: Real, n: int, form: Form, generator: np.random.Generator
) -> Real:
    """Return a period (n,) of root mean square 1; ``shape`` (lines,) are amplitudes.

    A multisine has random phases, a chirp Schroeder's, by which it sweeps.
    """
    phases = 2 * np.pi * generator.random(len(lines))
    if form == "chirp":
        passed = np.cumsum(shape**2)[:-1] / np.sum(shape**2)
        phases = -2 * np.pi * np.append(0.0, np.cumsum(passed * np.diff(lines)))
    spectrum = np.zeros(n // 2 + 1, complex)
    spectrum[lines] = shape * np.exp(1j * phases)
    values: Real = np.fft.irfft(spectrum, n)
    values /= np.sqrt(np.mean(values**2))
    return values


def spectra(
    values: Real, n: int, lines: Sequence[int] | Lines
) -> NDArray[np.complex128]:
    """Return phasors (periods, lines) of whole periods (periods * n,)."""
    found: NDArray[np.complex128] = np.fft.rfft(values.reshape(-1, n), axis=1)
    return found[:, np.asarray(lines)] * (2 / n)
