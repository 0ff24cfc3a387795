"""The matrix inequalities of an LPV controller, eliminated and closed-loop.

With N_X = null [C_2 D_21] and N_Y = null [B_2' D_12'] a controller of gain γ and
decay a exists where

    N_X' [XA + A'X + 2aX, XB_1, C_1'; *, -γI, D_11'; *, *, -γI] N_X < 0
    N_Y' [AY + YA' + 2aY - Ẏ, YC_1', B_1; *, -γI, D_11; *, *, -γI] N_Y < 0
    [X I; I Y] ≥ 0

(N acts on the first two blocks).  With the controller the closed loop fulfils

    [PA + A'P + 2aP + Ṗ, PB, C'; *, -γI, D'; *, *, -γI] < 0,   P > 0

Each is M - γE < 0 with E ≥ 0: ``least_gain`` returns the smallest γ by one Cholesky
factor and one eigenvalue, without a solver.

Source: Gahinet and Apkarian 1994; with parameters Apkarian and Adams 1998, as used
by Hanifzadegan 2014, eq. 4.9 to 4.12.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, null_space, solve_triangular

from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix, System


class Storage(NamedTuple):
    """X and Y with its rate at one point."""

    X: Matrix
    Y: Matrix
    Y_rate: Matrix


def null_x(plant: GeneralisedPlant) -> Matrix:
    """Return the matrix that the X-inequality is projected with."""
    free = null_space(np.hstack([plant.C_2, plant.D_21]))
    return np.asarray(block_diag(free, np.eye(plant.C_1.shape[0])))


def null_y(plant: GeneralisedPlant) -> Matrix:
    """Return the matrix that the Y-inequality is projected with."""
    free = null_space(np.hstack([plant.B_2.T, plant.D_12.T]))
    return np.asarray(block_diag(free, np.eye(plant.B_1.shape[1])))


def gain_of_x(plant: GeneralisedPlant, X: Matrix, decay: float = 0.0) -> float:
    """Return the smallest γ for which X fulfils its inequality; inf if none."""
    lyapunov = X @ plant.A + plant.A.T @ X + 2 * decay * X
    return _projected(null_x(plant), lyapunov, X @ plant.B_1, plant.C_1.T, plant.D_11.T)


def gain_of_y(
    plant: GeneralisedPlant, Y: Matrix, rate: Matrix, decay: float = 0.0
) -> float:
    """Return the smallest γ for which Y, at this rate, fulfils its inequality."""
    lyapunov = plant.A @ Y + Y @ plant.A.T + 2 * decay * Y - rate
    return _projected(null_y(plant), lyapunov, Y @ plant.C_1.T, plant.B_1, plant.D_11)


def gain_of_loop(loop: System, P: Matrix, rate: Matrix, decay: float = 0.0) -> float:
    """Return the smallest γ that P certifies for a closed loop; inf if none.

    P must be positive definite and, moving at ``rate``, a Lyapunov matrix.
    """
    if not _definite(P):
        return float("inf")
    lyapunov = P @ loop.A + loop.A.T @ P + 2 * decay * P + rate
    size = sum(loop.D.shape)
    eye = np.eye(len(P) + size)
    return _projected(eye, lyapunov, P @ loop.B, loop.C.T, loop.D.T)


def storage(s: Storage) -> tuple[Matrix, Matrix]:
    """Return P and Ṗ of the loop with the controller of ``reconstruction``.

    P = [X X; X Z], Z = XY (Y - X⁻¹)⁻¹
    """
    X, Y, rate = s
    gap = Y - np.linalg.inv(X)
    Z = np.linalg.solve(gap.T, (X @ Y).T).T
    Z_rate = np.linalg.solve(gap.T, (X @ rate - Z @ rate).T).T
    P = np.block([[X, X], [X, (Z + Z.T) / 2]])
    return P, np.asarray(block_diag(np.zeros_like(X), (Z_rate + Z_rate.T) / 2))


def coupling(X: Matrix, Y: Matrix) -> float:
    """Return the smallest eigenvalue of [X I; I Y]: no controller below zero."""
    eye = np.eye(len(X))
    return float(np.linalg.eigvalsh(np.block([[X, eye], [eye, Y]]))[0])


def _projected(N: Matrix, Q: Matrix, V: Matrix, W: Matrix, D: Matrix) -> float:
    """Return the least γ with N' [Q V W; * -γI D; * * -γI] N < 0."""
    n = len(Q)
    m, p = V.shape[1], W.shape[1]
    M = np.block(
        [
            [Q, V, W],
            [V.T, np.zeros((m, m)), D],
            [W.T, D.T, np.zeros((p, p))],
        ]
    )
    E = block_diag(np.zeros((n, n)), np.eye(m + p))
    return least_gain(N.T @ M @ N, N.T @ E @ N)


def least_gain(M: Matrix, E: Matrix) -> float:
    """Return the smallest γ with M - γE < 0, E ≥ 0; inf if there is none."""
    size, U = np.linalg.eigh(E)
    seen = size > 1e-9 * max(1.0, float(size[-1]))
    blind, scaled = U[:, ~seen], U[:, seen] / np.sqrt(size[seen])
    try:
        L = np.linalg.cholesky(-blind.T @ (M + M.T) @ blind / 2)
    except np.linalg.LinAlgError:
        return float("inf")
    W = solve_triangular(L, blind.T @ M @ scaled, lower=True)
    return float(np.linalg.eigvalsh(scaled.T @ M @ scaled + W.T @ W)[-1])


def _definite(P: Matrix) -> bool:
    try:
        np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return False
    return True
