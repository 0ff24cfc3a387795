"""Whether other tools agree with each other against us, signal by signal."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

AGAINST = 3  # tools that have to agree
DIFFERENT = 1e-6  # of a signal's largest magnitude; what exchange cannot explain
NEARER = 0.1  # of their distance to us, within which tools agree

Rows = tuple[NDArray[np.int64], NDArray[np.float64]]  # instants and values at them


def against(ours: NDArray[np.float64], theirs: Mapping[str, Rows]) -> tuple[str, ...]:
    """Return the tools that agree with each other and not with us; () if too few do."""
    laid = {tool: _laid(len(ours), *rows) for tool, rows in theirs.items()}
    size = max((float(np.nanmax(np.abs(v))) for v in (ours, *laid.values())), default=0)
    distance = {tool: _apart(ours, values) for tool, values in laid.items()}
    differing = [tool for tool, d in distance.items() if d > DIFFERENT * size]
    for tools in combinations(differing, AGAINST):
        least = min(distance[tool] for tool in tools)
        pairs = combinations(tools, 2)
        if all(_apart(laid[a], laid[b]) <= NEARER * least for a, b in pairs):
            return tools
    return ()


def _laid(
    rows: int, at: NDArray[np.int64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return values at their instants, not a number where there is none."""
    laid = np.full(rows, np.nan)
    there = (at >= 0) & (at < rows)
    laid[at[there]] = values[there]
    return laid


def _apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    difference = np.abs(a - b)
    return float(np.nanmax(difference)) if np.any(~np.isnan(difference)) else np.inf
