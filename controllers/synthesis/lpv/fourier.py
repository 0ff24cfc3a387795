"""Gain-scheduled controllers over an angle as Fourier series of sampled systems.

    M(θ) = M_0 + Σ_k (C_k cos kθ + S_k sin kθ),   k = 1 ... order

Where ρ is a direction a table of straight pieces needs many points to keep the
certificate; a few harmonics do, and θ need not be unwrapped.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.systems import Matrix, System


@dataclass(frozen=True)
class Fourier:
    """Series of systems sampled every ``T_s``.

    Matrices carry the harmonics in front, M_0, C_1, S_1, C_2, ...: A is
    (1 + 2 order, n, n).  ``axes`` holds no breakpoints.
    """

    T_s: float
    system: System
    axes: tuple[Matrix, ...] = ()

    @property
    def order(self) -> int:
        return len(self.system.A) // 2

    @property
    def points(self) -> list[Values]:
        """Angles that the series is fitted at."""
        return angles(self.order)

    def at(self, rho: Values) -> System:
        """Return the sampled system at the angle ρ (rad)."""
        waves = harmonics(np.array([rho[0]]), self.order)[0]
        return System(*(np.tensordot(waves, M, axes=1) for M in self.system))

    def remade(self, systems: Sequence[System]) -> System:
        """Return the matrices that systems at ``points`` give."""
        return _coefficients(systems, self.order)


def fitted(systems: Sequence[System], order: int, T_s: float) -> Fourier:
    """Return the series of sampled systems at ``angles(order)``."""
    return Fourier(T_s, _coefficients(systems, order))


def angles(order: int) -> list[Values]:
    """Return angles evenly around, as many as a fit of this order takes."""
    n = 8 * order
    return [(float(2 * np.pi * k / n),) for k in range(n)]


def harmonics(theta: Matrix, order: int) -> Matrix:
    """Return 1, cos θ, sin θ, cos 2θ, ... at angles (n,), shape (n, 1 + 2 order)."""
    k = np.arange(1, order + 1)
    waves = np.stack([np.cos(np.outer(theta, k)), np.sin(np.outer(theta, k))], axis=-1)
    return np.hstack([np.ones((len(theta), 1)), waves.reshape(len(theta), -1)])


def _coefficients(systems: Sequence[System], order: int) -> System:
    theta = np.array([rho[0] for rho in angles(order)])
    basis = harmonics(theta, order)
    # evenly around, the harmonics are orthogonal
    weights = basis.T / np.sum(basis**2, axis=0)[:, None]
    return System(
        *(
            np.tensordot(weights, np.stack(M), axes=1)
            for M in zip(*systems, strict=True)
        )
    )
