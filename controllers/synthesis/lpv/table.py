"""Gain-scheduled controllers as tables of sampled systems over ρ.

Linear between the breakpoints of each axis, held beyond them.  All points share one
state (``reconstruction``), balanced by the mean of their Gramians.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from controllers.synthesis.lpv.frozen import balancing
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.systems import Matrix, System


@dataclass(frozen=True)
class Table:
    """Systems sampled every ``T_s`` at all combinations of ``axes``.

    Matrices carry the axes in front: A is (len(axes[0]), ..., n, n).
    """

    axes: tuple[Matrix, ...]
    T_s: float
    system: System

    @property
    def points(self) -> list[Values]:
        """Values of ρ in the table, last axis fastest."""
        return points_of(self.axes)

    def at(self, rho: Values) -> System:
        """Return the sampled system at ρ."""
        return System(*(self._interpolated(M, rho) for M in self.system))

    def remade(self, systems: Sequence[System]) -> System:
        """Return the matrices that systems at ``points`` give."""
        return tabulated(systems, self.axes, self.T_s).system

    def _interpolated(self, M: Matrix, rho: Values) -> Matrix:
        for axis, value in zip(self.axes, rho, strict=True):
            i = int(np.clip(np.searchsorted(axis, value) - 1, 0, len(axis) - 2))
            share = np.clip((value - axis[i]) / (axis[i + 1] - axis[i]), 0.0, 1.0)
            M = M[i] + share * (M[i + 1] - M[i])
        return M


def points_of(axes: Sequence[Sequence[float] | Matrix]) -> list[Values]:
    """Return all combinations of breakpoints, last axis fastest."""
    return [tuple(map(float, rho)) for rho in product(*axes)]


def tabulated(
    systems: Sequence[System], axes: Sequence[Sequence[float] | Matrix], T_s: float
) -> Table:
    """Return a table of sampled systems given in the order of ``points_of``."""
    breakpoints = tuple(np.array(axis, dtype=float) for axis in axes)
    shape = tuple(len(axis) for axis in breakpoints)
    stacked = (np.stack(M) for M in zip(*systems, strict=True))
    return Table(
        breakpoints, T_s, System(*(M.reshape(*shape, *M.shape[1:]) for M in stacked))
    )


def balancing_states(systems: Sequence[System]) -> Matrix:
    """Return T that balances stable sampled systems together; x = T x_balanced.

    The mean observability and controllability Gramians become equal and diagonal.
    """
    seen = [solve_discrete_lyapunov(K.A.T, K.C.T @ K.C) for K in systems]
    driven = [solve_discrete_lyapunov(K.A, K.B @ K.B.T) for K in systems]
    return balancing(np.mean(seen, axis=0), np.mean(driven, axis=0))
