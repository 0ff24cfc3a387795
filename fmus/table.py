"""Table look-up that a model can use on signals and parameters alike.

Between table points linear, held beyond the ends: a sum of clipped segments, hence
traceable.  Breakpoints ascend strictly, 2 to 256 of them.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np


def lookup(x: Any, breakpoints: Any, values: Any) -> Any:
    """Interpolate between numbers.

    ``breakpoints`` (n,), ``values`` (n,); equals ``np.interp`` to 2e-16 of the
    largest value.

    Raises:
        ValueError: the table has fewer than 2 or more than 256 points.
    """
    y = values[0]
    for i, part, width in _segments(x, breakpoints):
        y = y + part * ((values[i + 1] - values[i]) / width)
    return y


def lookup_rows(x: Any, breakpoints: Any, rows: Any, slope: Any = None) -> Any:
    """Interpolate between matrices; shape (r, m).

    ``rows`` (n r, m) are the matrices of the n breakpoints one below the other.
    ``slope`` is what ``slopes`` computed of them in ``prepare``; without it, as for
    rows that are looked up themselves, differences are taken at every call.

    Raises:
        ValueError: fewer than 2 or more than 256 points, or rows left over.
    """
    r = _height(breakpoints, rows)
    y = rows[:r, :]
    for i, part, width in _segments(x, breakpoints):
        if slope is None:
            y = y + part / width * _rise(rows, i, r)
        else:
            y = y + part * slope[i * r : (i + 1) * r, :]
    return y


def slopes(breakpoints: Any, rows: Any) -> Any:
    """Return a table's slopes, (n r - r, m), of ``rows`` (n r, m).

    Raises:
        ValueError: fewer than 2 or more than 256 points, or rows left over.
    """
    r = _height(breakpoints, rows)
    widths = [width for _, _, width in _segments(breakpoints[0], breakpoints)]
    return np.concatenate([_rise(rows, i, r) / w for i, w in enumerate(widths)])


def _rise(rows: Any, i: int, r: int) -> Any:
    """Return what a table's matrix i + 1 is more than its matrix i."""
    return rows[(i + 1) * r : (i + 2) * r, :] - rows[i * r : (i + 1) * r, :]


def _segments(x: Any, breakpoints: Any) -> Iterator[tuple[int, Any, Any]]:
    """Yield number of each segment, the part of it below x, and its width."""
    for i in range(_points(breakpoints) - 1):
        width = breakpoints[i + 1] - breakpoints[i]
        yield i, np.minimum(np.maximum(x - breakpoints[i], 0.0), width), width


def _points(breakpoints: Any) -> int:
    n = int(breakpoints.shape[0])
    if not 2 <= n <= 256:
        raise ValueError(f"a lookup table has 2 to 256 points, not {n}")
    return n


def _height(breakpoints: Any, rows: Any) -> int:
    """Return how many rows one matrix of the table has."""
    n, stacked = _points(breakpoints), int(rows.shape[0])
    if len(rows.shape) != 2 or stacked % n:
        raise ValueError(
            f"a table of matrices has them one below the other: {n} points cannot "
            f"share out an array of shape {tuple(rows.shape)}"
        )
    return stacked // n
