"""Compositions whose loops are measured, and how far two responses are apart."""

import numpy as np
from numpy.typing import NDArray

from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

Complex = NDArray[np.complex128]


def composed(name: str, *sets: str) -> Composition:
    """Return a published scenario with ``--set``, composed."""
    return compose(load_scenario(name, sets), run_earlier)


def decibels(one: Complex, other: Complex) -> float:
    """Return the largest difference of magnitude (dB)."""
    return float(np.max(np.abs(20 * np.log10(np.abs(one / other)))))


def degrees(one: Complex, other: Complex) -> float:
    """Return the largest difference of phase (deg)."""
    return float(np.max(np.abs(np.angle(one / other, deg=True))))
