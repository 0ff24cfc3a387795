"""H-infinity controllers by two Riccati equations, on SciPy alone.

Formulas of Glover and Doyle for the central controller, with γ scaled out and
D_12 = [0; I], D_21 = [0 I] by rotation of z and w:

    X, Y stabilise the Riccati equations of [A B; C_1 D_1] and [A C; B_1 D_1]
    K exists where R, R̃ are invertible and ρ(X Y) < 1

A γ counts only if the controller it gives stabilises and the loop's true norm is
at most 1.001 γ: sign tests on X and Y are lost in rounding long before the
optimum (for a weight of 1e7 they stop at twice of it).

Source: Zhou, Doyle, Glover, Robust and Optimal Control, 1996, theorem 17.1.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, schur

from controllers.synthesis.lpv.coordinates import suitable
from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix, System, abscissa

TRUE = 1.001  # the true norm may exceed γ by this factor


class Optimum(NamedTuple):
    """A controller (SI), the smallest γ found, and the loop's true norm."""

    K: System
    gamma: float
    norm: float


def h_infinity(
    plant: GeneralisedPlant, time: float = 1e-3, tolerance: float = 1e-4
) -> Optimum:
    """Return the controller of smallest norm from w to z.

    Args:
        plant: the plant with its weights; D_12 and D_21 of full rank.
        time: unit of time (s) for conditioning.
        tolerance: relative width at which the bisection ends.

    Raises:
        ValueError: no γ between 1e-6 and 1e9 gives a controller.
    """
    coordinates = suitable([plant], time)
    best = optimum(coordinates.plant(plant), tolerance)
    return best._replace(K=coordinates.controller(best.K))


def optimum(plant: GeneralisedPlant, tolerance: float = 1e-4) -> Optimum:
    """Return the optimum of a plant that is in suitable units already.

    Raises:
        ValueError: no γ between 1e-6 and 1e9 gives a controller.
    """
    best: Optimum | None = None
    low, high = 1e-6, 1e9
    while high / low > 1 + tolerance:
        gamma = float(np.sqrt(low * high))
        found = _attempt(plant, gamma)
        if found is None:
            low = gamma
        else:
            best, high = found, gamma
    if best is None:
        raise ValueError("no controller stabilises the plant with any gamma up to 1e9")
    return best


def _attempt(plant: GeneralisedPlant, gamma: float) -> Optimum | None:
    """Return the central controller of gamma if it keeps what gamma says."""
    try:
        K = central(plant, gamma)
        loop = plant.close(K)
        if not np.all(np.isfinite(loop.A)) or abscissa(loop) >= 0:
            return None
        norm, _ = peak(loop)
    except (LinAlgError, ValueError):
        return None
    return Optimum(K, gamma, norm) if norm <= TRUE * gamma else None


def central(plant: GeneralisedPlant, gamma: float) -> System:
    """Return the central controller for gamma.

    Raises:
        ValueError, LinAlgError: there is none.
    """
    n = _normalised(plant, gamma)
    D_11, B = n.plant.D_11, np.hstack([n.plant.B_1, n.plant.B_2])
    (p_1, m_1), p_2, m_2 = D_11.shape, len(n.unit_y), len(n.unit_u)
    a, b = p_1 - m_2, m_1 - p_2
    X, Y, F, L = _gains(n.plant)
    D_aa, D_ab, D_ba, D_bb = D_11[:a, :b], D_11[:a, b:], D_11[a:, :b], D_11[a:, b:]
    left = np.linalg.inv(np.eye(a) - D_aa @ D_aa.T)
    D = -D_ba @ D_aa.T @ left @ D_ab - D_bb
    Z = np.linalg.inv(np.eye(plant.order) - Y @ X)
    B_K = Z @ ((n.plant.B_2 + L[:, a:p_1]) @ D - L[:, p_1:])
    C_y = -(n.plant.C_2 + F[b:m_1])
    return System(
        n.plant.A + B @ F + B_K @ C_y,
        B_K @ n.unit_y,
        n.unit_u @ (F[m_1:] + D @ C_y),
        n.unit_u @ D @ n.unit_y,
    )


def riccati(plant: GeneralisedPlant, gamma: float) -> tuple[Matrix, Matrix]:
    """Return X and Y of the two equations at gamma, in the plant's states.

    Raises:
        ValueError, LinAlgError: there are none.
    """
    X, Y, _, _ = _gains(_normalised(plant, gamma).plant)
    return X, Y


class _Normalised(NamedTuple):
    """Plant of γ = 1, D_12 = [0; I], D_21 = [0 I]; u and y in these units."""

    plant: GeneralisedPlant
    unit_u: Matrix
    unit_y: Matrix


def _normalised(plant: GeneralisedPlant, gamma: float) -> _Normalised:
    root = np.sqrt(gamma)
    (p_1, m_2), (p_2, m_1) = plant.D_12.shape, plant.D_21.shape
    U, size_u, V = np.linalg.svd(plant.D_12)
    rotate_z, unit_u = np.hstack([U[:, m_2:], U[:, :m_2]]), V.T / size_u * root
    U, size_y, V = np.linalg.svd(plant.D_21)
    rotate_w, unit_y = np.vstack([V[p_2:], V[:p_2]]).T, (U / size_y).T * root
    normalised = GeneralisedPlant(
        plant.A,
        plant.B_1 @ rotate_w / root,
        plant.B_2 @ unit_u,
        rotate_z.T @ plant.C_1 / root,
        unit_y @ plant.C_2,
        rotate_z.T @ plant.D_11 @ rotate_w / gamma,
        np.eye(p_1)[:, p_1 - m_2 :],
        np.eye(m_1)[m_1 - p_2 :],
    )
    return _Normalised(normalised, unit_u, unit_y)


def _gains(n: GeneralisedPlant) -> tuple[Matrix, ...]:
    """Return X, Y and the gains F and L of a normalised plant."""
    (p_1, m_2), (p_2, m_1) = n.D_12.shape, n.D_21.shape
    B, C = np.hstack([n.B_1, n.B_2]), np.vstack([n.C_1, n.C_2])
    D_1u, D_y1 = np.hstack([n.D_11, n.D_12]), np.vstack([n.D_11, n.D_21])
    R = D_1u.T @ D_1u - np.diag([1.0] * m_1 + [0.0] * m_2)
    S = D_y1 @ D_y1.T - np.diag([1.0] * p_1 + [0.0] * p_2)
    X = stabilising(n.A, B, n.C_1.T @ n.C_1, R, n.C_1.T @ D_1u)
    Y = stabilising(n.A.T, C.T, n.B_1 @ n.B_1.T, S, n.B_1 @ D_y1.T)
    F = -np.linalg.solve(R, D_1u.T @ n.C_1 + B.T @ X)
    L = -np.linalg.solve(S, D_y1 @ n.B_1.T + C @ Y).T
    return X, Y, F, L


def stabilising(A: Matrix, B: Matrix, Q: Matrix, R: Matrix, S: Matrix) -> Matrix:
    """Return X of A'X + XA - (XB + S) R⁻¹ (XB + S)' + Q = 0 with A - BK stable.

    R may be indefinite.  By ordered Schur form of the Hamiltonian: that of the
    extended pencil (``solve_continuous_are``) fails here for one γ in three.

    Raises:
        ValueError: an eigenvalue lies on the imaginary axis: there is none.
    """
    R_inv = np.linalg.inv(R)
    A_0 = A - B @ R_inv @ S.T
    H = np.block([[A_0, -B @ R_inv @ B.T], [-(Q - S @ R_inv @ S.T), -A_0.T]])
    _, U, stable = schur(H, output="real", sort="lhp")
    n = len(A)
    if stable != n:
        raise ValueError("the Hamiltonian has eigenvalues on the imaginary axis")
    X = np.linalg.solve(U[:n, :n].T, U[n:, :n].T)
    return np.asarray((X + X.T) / 2)
