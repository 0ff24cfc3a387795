"""Gridded LQG along a path: the test of contouring without inequalities.

    x̂⁺ = F x̂ + G u + L (y - C x̂),   y = r - u_c,   w⁺ = A_w w + B_w T e
    u = -K(q) (x̂, w)

An LQR for each point of a grid over the path (the path standing still there), one
Kalman filter for all: its noise is white, ``ratio`` times as intense at the commands
as at the positions.  T takes the error to (e_t, e_nbx, e_nby): the error across has
rank two and its third component would have no solution.  Nothing certifies what is
between the points of the grid.
Source: Hanifzadegan 2014, sec. 8.5, Table 8.4; gridded LQG is ours.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from controllers.synthesis.contouring_lpv.planar import axis_model, beside
from controllers.synthesis.lpv.systems import Matrix, System, tustin
from controllers.synthesis.lpv.weights import decibels, shelf
from controllers.three_axis.space_path import Parameters, tangent
from plants.three_axis._axes import X, Y, Z

W_T = (decibels(-126), 1.01, 1570.0, 2)  # M_L, M_H (no decibels), ω_b (rad/s), k
W_N = (decibels(-160), 1.06, 2200.0, 2)
FASTEST = 1000.0  # rad/s: modes beyond are left out of the design
T_S = 1 / 4000  # s


class Gains(NamedTuple):
    """The controller: plant F, G, C; weights A_w, B_w; L; K (n, m, states)."""

    F: Matrix
    G: Matrix
    C: Matrix
    A_w: Matrix
    B_w: Matrix
    L: Matrix
    K: Matrix


def frame(q: float, alpha_0: float) -> Matrix:
    """Return T at a share q of the path: e to e_t and two parts of e_nb."""
    t = np.array([float(part) for part in tangent(q, alpha_0)])
    return np.vstack([t, (np.eye(3) - np.outer(t, t))[:2]])


def design(
    frames: Sequence[Matrix], W_v: float, ratio: float, T_s: float = T_S
) -> Gains:
    """Return the gains for frames of a grid.

    Args:
        frames: T at each point of the grid.
        W_v: weight on each command (1/V).
        ratio: intensity of noise at the commands over that at the positions (V²/m²).
        T_s: sample time (s).
    """
    plant = beside([axis_model(axis, FASTEST) for axis in (X, Y, Z)])
    F, G = held(plant, T_s)
    across = shelf(*W_N)
    weights = tustin(beside([shelf(*W_T), across, across]), T_s)
    noise = ratio * G @ G.T / T_s
    P = solve_discrete_are(F.T, plant.C.T, noise, np.eye(3) / T_s)
    L = F @ P @ plant.C.T @ np.linalg.inv(plant.C @ P @ plant.C.T + np.eye(3) / T_s)
    K = np.array([_gain(F, G, plant.C, weights, T, W_v) for T in frames])
    return Gains(F, G, -plant.C, weights.A, weights.B, -L, K)


def held(plant: System, T_s: float) -> tuple[Matrix, Matrix]:
    """Return F and G of a plant whose command is held over T_s."""
    n, m = plant.B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = plant.A, plant.B
    whole = expm(whole * T_s)
    return whole[:n, :n], whole[:n, n:]


def _gain(
    F: Matrix, G: Matrix, C: Matrix, weights: System, T: Matrix, W_v: float
) -> Any:
    n, k, m = len(F), len(weights.A), G.shape[1]
    A = np.block([[F, np.zeros((n, k))], [-weights.B @ T @ C, weights.A]])
    B = np.vstack([G, np.zeros((k, m))])
    H = np.hstack([-weights.D @ T @ C, weights.C])
    S = solve_discrete_are(A, B, H.T @ H, W_v**2 * np.eye(m))
    return np.linalg.solve(W_v**2 * np.eye(m) + B.T @ S @ B, B.T @ S @ A)


def along(grid: Matrix, alpha_0: float = Parameters().alpha_0) -> list[Matrix]:
    """Return T at shares (n,) of the path."""
    return [frame(float(q), alpha_0) for q in grid]
