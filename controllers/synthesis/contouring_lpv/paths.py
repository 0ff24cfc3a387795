"""What the two paths ask of the machine: extent, speed, turning."""

from typing import Any

import numpy as np

from controllers.synthesis.lpv.systems import Matrix
from controllers.three_axis import rose, space_path

T_S = 1e-3  # s


def in_the_plane(t_r: float = 0.5) -> dict[str, float]:
    """Return the largest |x|, |y| (m), speed (m/s), θ̇ (rad/s) and the turns of θ."""
    found = _run(rose, rose.Parameters(t_r=t_r))
    rate = np.angle(_turned(found[1:]) / _turned(found[:-1])) / T_S
    return {
        "extent": float(np.max(np.abs(found[:, :2]))),
        "speed": float(np.max(np.hypot(found[:, 2], found[:, 3]))),
        "turning": float(np.max(np.abs(rate))),
        "turns": float(np.sum(rate) * T_S / (2 * np.pi)),
    }


def in_space(t_r: float = 0.5) -> dict[str, float]:
    """Return the largest angles to the axes (rad) and their rates (rad/s)."""
    alpha = np.arccos(_run(space_path, space_path.Parameters(t_r=t_r))[:, 3:6])
    rates = np.abs(np.diff(alpha, axis=0)) / T_S
    found = {f"alpha_{n}": float(a) for n, a in zip("xyz", alpha.max(0), strict=True)}
    return found | {
        f"rate_{n}": float(r) for n, r in zip("xyz", rates.max(0), strict=True)
    }


def _run(path: Any, p: Any) -> Matrix:
    """Return the outputs of a path at every tick, one row each."""
    x, rows = path.State(), []
    for _ in range(round(p.T / T_S) + 1):
        x, y = path.step(x, path.Input(), p, T_S)
        rows.append(y)
    return np.array(rows, dtype=float)


def _turned(rows: Matrix) -> Any:
    """Return the tangents of the plane as complex numbers."""
    return rows[:, 4] + 1j * rows[:, 5]
