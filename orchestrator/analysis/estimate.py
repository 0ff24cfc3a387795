"""Bounded least squares with what it is worth: covariance, correlation, intervals.

Residuals r(x) of n rows with noise of one size: x minimises r·r in its bounds, s² =
r·r / (n - p), the covariance is s² (JᵀJ)⁻¹ (Seber and Wild 1989, section 2.1.2).
This takes the noise to be independent from row to row; ``lag_1`` tells.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FitError

Array: TypeAlias = NDArray[np.float64]

STEP = 1e-4  # of a scale, for the central differences of the Jacobian
TOLERANCE = 1e-10
LEAST = 1e-7  # of the largest singular value: less is no information
EDGE = 1e-6  # of a bracket: nearer to its end is at its end


@dataclass(frozen=True)
class Estimate:
    """Values (p,), their standard errors and 95 % intervals (p, 2), correlation (p, p).

    ``at_bound`` tells which values their bracket holds; ``runs`` counts evaluations.
    """

    values: Array
    standard_errors: Array
    intervals: Array
    covariance: Array
    correlation: Array
    residuals: Array
    at_bound: NDArray[np.bool_]
    runs: int


def estimate(
    residuals: Callable[[Array], Array],
    start: Array,
    brackets: Array,
    names: tuple[str, ...],
) -> Estimate:
    """Return where ``residuals(x)`` (n,) are least, x (p,) within ``brackets`` (p, 2).

    Raises:
        FitError: there are too few rows, or they do not tell the values apart.
    """
    from scipy.optimize import least_squares
    from scipy.stats import t

    scale = np.where(start != 0, np.abs(start), np.ptp(brackets, axis=1) / 2)
    runs = 0

    def scaled(x: Array) -> Array:
        nonlocal runs
        runs += 1
        return residuals(x * scale)

    found = least_squares(
        scaled,
        start / scale,
        jac="3-point",
        diff_step=STEP,
        bounds=tuple((brackets / scale[:, None]).T),
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=TOLERANCE,
    )
    if not found.success:
        raise FitError(f"the fit did not converge in {runs} runs: {found.message}")
    n, p = found.jac.shape
    if n <= p:
        raise FitError(f"{n} rows do not tell {p} values")
    _, sizes, directions = np.linalg.svd(found.jac, full_matrices=False)
    if sizes[-1] <= LEAST * sizes[0]:
        raise FitError(_undetermined(directions[-1], names))
    spread = float(found.fun @ found.fun) / (n - p)
    inverse = (directions.T / sizes**2) @ directions
    values = found.x * scale
    covariance = spread * inverse * np.outer(scale, scale)
    errors = np.sqrt(np.diag(covariance))
    reach = t.ppf(0.975, n - p) * errors
    room = np.min(np.abs(brackets - values[:, None]), axis=1)
    return Estimate(
        values,
        errors,
        np.stack([values - reach, values + reach], axis=1),
        covariance,
        covariance / np.outer(errors, errors),
        np.asarray(found.fun),
        room < EDGE * np.ptp(brackets, axis=1),
        runs,
    )


def _undetermined(direction: Array, names: tuple[str, ...]) -> str:
    large = [n for n, d in zip(names, direction, strict=True) if abs(d) > 0.1]
    if len(large) == 1:
        return (
            f"the data do not tell {large[0]}: nothing that is compared changes with "
            f"it; leave it out of --free"
        )
    return (
        f"the data tell only a combination of {', '.join(large)}, not each of them; "
        f"leave one out of --free, or measure what tells them apart"
    )


def lag_1(residuals: Array) -> float:
    """Return the correlation of residuals from one row to the next; 0 if all are 0."""
    about = residuals - np.mean(residuals)
    size = float(about @ about)
    return float(about[1:] @ about[:-1]) / size if size else 0.0
