"""Scenarios of the studies, run for their rows alone; how far rows are apart."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orchestrator.outcome import Run
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

Array = NDArray[np.float64]
Co = Callable[..., Run]


def simulated(folder: Path, scenario: str, *overrides: str) -> Run:
    """Run "study/scenario" with overrides, without a report."""
    return run(load_scenario(scenario, overrides), folder, report=False)


def far(got: Array, expected: Array) -> float:
    """Return the largest difference relative to the largest value."""
    return float(np.max(np.abs(got - expected)) / np.max(np.abs(expected)))
