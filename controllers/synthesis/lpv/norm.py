"""Largest gain of a system over frequency."""

import numpy as np
from scipy.optimize import minimize_scalar

from controllers.synthesis.lpv.systems import (
    ComplexArray,
    Matrix,
    System,
    poles,
    response,
)


def peak(system: System, omega: Matrix | None = None) -> tuple[float, float]:
    """Return the largest singular value over frequency and where it is (rad/s).

    The grid (by default six decades around the poles, with the poles themselves)
    is refined about its largest value; ω = ∞ counts.

    Raises:
        ValueError: the system is unstable, it has no norm.
    """
    at = poles(system)
    if np.max(at.real) >= 0:
        raise ValueError(f"unstable: a pole at {at[np.argmax(at.real)]:.4g} rad/s")
    if omega is None:
        omega = _grid(at)
    gains = singular_values(system, omega)
    k = int(np.argmax(gains))
    ends = np.log(omega[max(k - 1, 0)]), np.log(omega[min(k + 1, len(omega) - 1)])

    def less(log_omega: float) -> float:
        return -float(singular_values(system, np.exp([log_omega]))[0])

    refined = minimize_scalar(
        less, bounds=ends, method="bounded", options={"xatol": 1e-9}
    )
    found = [
        (float(gains[k]), float(omega[k])),
        (-float(refined.fun), float(np.exp(refined.x))),
        (float(np.linalg.norm(system.D, 2)), np.inf),
    ]
    return max(found)


def _grid(at: ComplexArray) -> Matrix:
    """Return frequencies (rad/s) that see every resonance of poles."""
    size = np.abs(at[at != 0])
    around = np.linspace(0.95, 1.05, 11)
    wide = np.geomspace(size.min() / 1e3, size.max() * 1e3, 1500)
    return np.unique(np.concatenate([wide, np.outer(size, around).ravel()]))


def singular_values(system: System, omega: Matrix) -> Matrix:
    """Return the largest singular value at frequencies (n,) (rad/s)."""
    G = response(system, 1j * np.asarray(omega))
    return np.asarray(np.linalg.svd(G, compute_uv=False)[:, 0])
