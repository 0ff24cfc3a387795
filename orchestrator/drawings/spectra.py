"""What a figure shows of evenly recorded values: their rate, their spectra."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


def rate(time: Array, values: Array) -> Array:
    """Return the backward difference (n,) over time; its first value repeats."""
    found = np.diff(values) / np.diff(time)
    return np.concatenate([found[:1], found])


def spectrum(time: Array, values: Array) -> tuple[Array, Array]:
    """Return frequencies (Hz) and amplitudes of the lines, mean taken away, no window.

    A sine that fits the record has its amplitude at its line.
    """
    n = len(values)
    hz, size = _lines(values, _period(time))
    return hz, 2 * size / n


def density(time: Array, values: Array) -> tuple[Array, Array]:
    """Return frequencies (Hz) and the amplitude spectral density, unit/sqrt(Hz).

    The root of the one-sided periodogram, mean taken away: the integral of its
    square is the variance.
    """
    n, T = len(values), _period(time)
    hz, size = _lines(values, T)
    return hz, size * np.sqrt(2 * T / n)


def _lines(values: Array, T: float) -> tuple[Array, Array]:
    lines = np.abs(np.fft.rfft(values - np.mean(values)))
    hz = np.fft.rfftfreq(len(values), T)
    return np.asarray(hz[1:], dtype=float), np.asarray(lines[1:], dtype=float)


def _period(time: Array) -> float:
    return float(time[-1] - time[0]) / (len(time) - 1)
