"""Mass, damping and stiffness of a two-motor gantry from its frequency responses.

The measured G(jω), end positions by motor forces, shall satisfy G Z = I with

    Z = K - ω² M + jω C,    Θ = (m_11 m_12 m_22 c_11 c_12 c_22 k_11 k_12 k_22)

in the least-squares sense, equal weights, subject to a free rigid-body motion and
the known mass and its distribution:

    m_11 + m_12 = α_1 m,  m_12 + m_22 = α_2 m
    c_11 = c_22,  c_11 + c_12 = 0,   k_11 = k_22,  k_11 + k_12 = 0

Source: Gordon 2010, eq. 4.5 to 4.16, corrected: in 4.9 the columns of c_ij bear
ω h, not ω² h, and the seventh constraint of 4.13 follows from the others
(docs/studies/gantry.md).
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray


class Gantry(NamedTuple):
    """J (V m s²), c (V m s), k (V m) of the yaw, its frequency (Hz) and damping."""

    J: float
    c: float
    k: float
    frequency: float
    damping: float


def identify(
    f_hz: FloatArray, G: ComplexArray, m: float, alpha_1: float, L: float
) -> Gantry:
    """Return the gantry that explains measured frequency responses.

    Args:
        f_hz: frequencies, shape (n,) (Hz).
        G: responses (f_1, f_2) → (y_1, y_2), shape (n, 2, 2) (m/V).
        m: mass of gantry and table (V s²/m).
        alpha_1: share of it at the left end.
        L: distance of the ends (m).

    Raises:
        ValueError: the shapes do not fit, or the equations have no solution.
    """
    f_hz, G = np.asarray(f_hz, dtype=float), np.asarray(G, dtype=complex)
    if G.shape != (len(f_hz), 2, 2):
        raise ValueError(f"G is of shape {G.shape}, not {(len(f_hz), 2, 2)}")
    A, b = equations(f_hz, G)
    B, d = constraints(m, alpha_1)
    # stiffness and mass differ by 1e5: columns of one size
    scale = np.linalg.norm(A, axis=0)
    *_, solution, info = lapack.dgglse(A / scale, B / scale, b, d)
    if info:
        raise ValueError("the responses do not determine the gantry")
    theta: FloatArray = solution / scale
    return _physical(theta, m, alpha_1, L)


def equations(f_hz: FloatArray, G: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return A (8n, 9) and b (8n,) of the least squares, real over imaginary parts.

    A row of G, (p, q), gives p Z_11 + q Z_12 and p Z_12 + q Z_22 (eq. 4.7 to 4.12).
    """
    omega = 2 * np.pi * f_hz[:, None, None]
    zero = np.zeros_like(G[:, :, 0])
    p, q = G[:, :, 0], G[:, :, 1]
    first = np.stack([p, q, zero], axis=-1)
    second = np.stack([zero, p, q], axis=-1)
    # (n, row of G, column of I, 3): which of Z_11, Z_12, Z_22 enters
    entries = np.stack([first, second], axis=2)
    omega = omega[..., None]
    rows = np.concatenate(
        [-(omega**2) * entries, 1j * omega * entries, entries], axis=-1
    ).reshape(-1, 9)
    wanted = np.tile(np.eye(2).ravel(), len(f_hz))
    A = np.concatenate([rows.real, rows.imag])
    return A, np.concatenate([wanted, np.zeros_like(wanted)])


def constraints(m: float, alpha_1: float) -> tuple[FloatArray, FloatArray]:
    """Return B (6, 9) and d (6,) of B Θ = d (eq. 4.13 without its redundant row)."""
    B = np.zeros((6, 9))
    B[0, [0, 1]] = B[1, [1, 2]] = 1.0
    for row, first in ((2, 3), (4, 6)):
        B[row, [first, first + 2]] = 1.0, -1.0
        B[row + 1, [first, first + 1]] = 1.0
    return B, np.array([alpha_1 * m, (1 - alpha_1) * m, 0.0, 0.0, 0.0, 0.0])


def _physical(theta: FloatArray, m: float, alpha_1: float, L: float) -> Gantry:
    """Return the yaw's parameters from Θ (eq. 4.3)."""
    a_1, a_2 = (1 - alpha_1) * L, alpha_1 * L
    J = a_1 * a_2 * m - L * L * theta[1]
    c, k = L * L * theta[3], L * L * theta[6]
    omega = np.sqrt(k / J)
    frequency, damping = omega / (2 * np.pi), c / (2 * np.sqrt(J * k))
    return Gantry(*map(float, (J, c, k, frequency, damping)))


def responses(
    f_hz: FloatArray, T_s: float, u: FloatArray, y: FloatArray
) -> ComplexArray:
    """Return G(jω) of a plant with held inputs from two periodic experiments.

    Args:
        f_hz: excited lines, shape (n,) (Hz), each with whole periods in the record.
        T_s: sample time (s).
        u, y: inputs held from each instant on and outputs at it, shape
            (experiment, sample, signal), both experiments of one length.

    Returns:
        Shape (n, 2, 2), the hold divided out; aliases of it, (f T_s)³, remain.

    Raises:
        ValueError: a line does not complete whole periods.
    """
    n = u.shape[1]
    lines = np.asarray(f_hz) * (n * T_s)
    at = np.rint(lines).astype(int)
    if np.max(np.abs(lines - at)) > 1e-6:
        raise ValueError(
            f"the record of {n * T_s:g} s does not hold whole periods of every line"
        )
    # (line, signal, experiment)
    U, Y = (np.moveaxis(np.fft.rfft(v, axis=1)[:, at], 0, 2) for v in (u, y))
    delay = 2j * np.pi * np.asarray(f_hz) * T_s
    hold = -np.expm1(-delay) / delay
    return np.asarray(Y @ np.linalg.inv(U) / hold[:, None, None])
