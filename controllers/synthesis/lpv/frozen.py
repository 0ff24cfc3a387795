"""What frozen plants say about an LPV design: a lower bound, and good states.

No controller that works for all trajectories is better than the H-infinity optimum
of a plant that stands still.  The Riccati solutions of that optimum foretell X and Y;
in states that balance their means the inequalities are well conditioned (without,
the solver stops on the vibration controller of a ball screw for nearly every
setting; with, all settings give the same γ to six digits).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates, suitable
from controllers.synthesis.lpv.h_infinity import optimum, riccati
from controllers.synthesis.lpv.problem import PlantAt, Values
from controllers.synthesis.lpv.systems import Matrix

ROUNDING = 1e-15
COARSE = 1e-2  # relative width of γ for a bound
BACK_OFF = 1.5  # of γ for the Riccati solutions: at the optimum they degenerate


def frozen_optima(
    plant: PlantAt, at: Sequence[Values], time: float, gain: float = 1.0
) -> Matrix:
    """Return the H-infinity optima of plants that stand still, (len(at),).

    Args:
        plant: the plant at ρ, SI.
        at: values of ρ.
        time, gain: units for conditioning, as of ``suitable``.
    """
    plants = [plant(rho) for rho in at]
    units = suitable(plants, time, gain)
    return np.array([optimum(units.plant(p)).gamma * gain for p in plants])


def balanced(
    plant: PlantAt,
    at: Sequence[Values],
    time: float,
    gain: float = 1.0,
    floors: tuple[float, float] = (0.0, 0.0),
) -> tuple[Coordinates, float]:
    """Return units and states for an LPV design, and a lower bound of its γ.

    The bound is that of ``frozen_optima``, 1 % low.  A few values of ρ, the ends
    among them, suffice.  ``floors``, shares of the largest eigenvalue, are added to
    the control's and the estimator's Riccati solution: the latter is singular where
    y tells some states exactly.
    """
    plants = [plant(rho) for rho in at]
    units = suitable(plants, time, gain)
    X, Y, bound = *np.zeros((2, plants[0].order, plants[0].order)), 0.0
    for scaled in map(units.plant, plants):
        gamma = optimum(scaled, COARSE).gamma
        control, estimate = riccati(scaled, BACK_OFF * gamma)
        X, Y = X + control / len(plants), Y + estimate / len(plants)
        bound = max(bound, gain * gamma / (1 + COARSE))
    X, Y = (
        R + floor * np.linalg.norm(R, 2) * np.eye(len(R))
        for R, floor in zip((X, Y), floors, strict=True)
    )
    T = units.T @ balancing(np.linalg.inv(Y), np.linalg.inv(X))
    return replace(units, T=T), bound


def of_control(
    plant: PlantAt, at: Sequence[Values], time: float, gain: float
) -> tuple[Coordinates, float]:
    """Return as ``balanced`` states in which the control's mean solution is I.

    For γ near ``gain``: the solutions are those at 1.5 times of it.  The estimator has
    no say, and the solver stops earlier: what it finds is further inside.
    """
    plants = [plant(rho) for rho in at]
    units = suitable(plants, time, gain)
    scaled = [units.plant(p) for p in plants]
    bound = max(optimum(p, COARSE).gamma for p in scaled) * gain / (1 + COARSE)
    X = np.mean([riccati(p, BACK_OFF)[0] for p in scaled], axis=0)
    L = np.linalg.cholesky((X + X.T) / 2)
    return replace(units, T=units.T @ np.linalg.inv(L).T), bound


def balancing(P: Matrix, Q: Matrix) -> Matrix:
    """Return T with T'PT = T⁻¹QT⁻' diagonal, for positive definite P and Q.

    What is lost in rounding counts as just above it.  The largest entry of each
    column is positive: T is unique but for equal entries.
    """
    L, _ = _root(Q)
    U, size = _root(L.T @ P @ L)
    T = L @ U / size**1.5
    largest = T[np.argmax(np.abs(T), axis=0), range(len(T))]
    return np.asarray(T * np.sign(largest))


def _root(Q: Matrix) -> tuple[Matrix, Matrix]:
    """Return L with LL' = Q from its eigenvectors, and the sizes of its columns."""
    square, U = np.linalg.eigh((Q + Q.T) / 2)
    size = np.sqrt(np.maximum(square, ROUNDING * square[-1]))
    return U * size, size
