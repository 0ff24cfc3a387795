"""Identification of the trajectory pre-filter from one recorded run.

    e_2 = x_r - y_2 ≈ K_vel v_f + K_acc a_f + K_jerk j_f + K_snap s_f

by least squares over the whole record, run with the four gains at zero.  The
regressors are those of the run-time pre-filter itself.  Their norms differ by 1e7:
columns are scaled to unit norm first, or the solver drops some.
Source: Gordon 2010, equations 3.16 to 3.20.
"""

import numpy as np

from controllers.filters import prefilter
from fmus.model import FloatArray

GAINS = ("K_vel", "K_acc", "K_jerk", "K_snap")


def identify(
    x_r: FloatArray, y_2: FloatArray, T_s: float, f_hz: float = 80.0
) -> dict[str, float]:
    """Return the pre-filter's gains that explain a recorded tracking error.

    Args:
        x_r: command, shape (n,) (rad), at rest before the first sample.
        y_2: linear encoder at the same instants, shape (n,) (rad).
        T_s: sample time (s).
        f_hz: pole of the pre-filter's low-passes (Hz).

    Returns:
        K_vel (s), K_acc (s²), K_jerk (s³), K_snap (s⁴).

    Raises:
        ValueError: the signals differ in length, or the command does not move.
    """
    x_r, y_2 = np.asarray(x_r, dtype=float), np.asarray(y_2, dtype=float)
    if x_r.ndim != 1 or x_r.shape != y_2.shape:
        raise ValueError(
            f"x_r and y_2 are one signal each on the same instants, "
            f"not of shapes {x_r.shape} and {y_2.shape}"
        )
    phi = regressors(x_r, T_s, f_hz)
    norms = np.linalg.norm(phi, axis=0)
    if not np.all(norms > 0):
        raise ValueError("the command does not move: nothing to identify from")
    K, *_ = np.linalg.lstsq(phi / norms, x_r - y_2)
    return dict(zip(GAINS, map(float, K / norms), strict=True))


def regressors(x_r: FloatArray, T_s: float, f_hz: float) -> FloatArray:
    """Return v_f, a_f, j_f, s_f as the run-time pre-filter has them, shape (n, 4)."""
    p = prefilter.Parameters(omega_c_hz=f_hz)
    derived = prefilter.prepare(p, T_s)
    x = prefilter.State()
    phi = np.empty((len(x_r), len(GAINS)))
    for k, command in enumerate(x_r):
        x, y = prefilter.step(x, prefilter.Input(command), p, T_s, derived)
        phi[k] = y.v_f, y.a_f, y.j_f, y.s_f
    return phi
