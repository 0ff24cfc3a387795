"""Units in which a synthesis problem is well conditioned.

A synthesis sees no entry far above 10 if time, gain, signals and states have
suitable units.  Controllers found in them are brought back to SI.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix, System


@dataclass(frozen=True)
class Coordinates:
    """Unit of time (s), of the gain w → z, of each u and y; x = T x_scaled."""

    T: Matrix
    time: float
    u: Matrix
    y: Matrix
    gain: float = 1.0

    def plant(self, plant: GeneralisedPlant) -> GeneralisedPlant:
        """Return a plant in these units."""
        root = np.sqrt(self.gain)
        rows, columns = 1 / self.y[:, None], self.u[None, :]

        def into(B: Matrix) -> Matrix:
            return np.asarray(np.linalg.solve(self.T, B)) * self.time

        return GeneralisedPlant(
            into(plant.A @ self.T),
            into(plant.B_1) / root,
            into(plant.B_2) * columns,
            plant.C_1 @ self.T / root,
            rows * plant.C_2 @ self.T,
            plant.D_11 / self.gain,
            plant.D_12 * columns / root,
            rows * plant.D_21 / root,
        )

    def controller(self, K: System) -> System:
        """Return in SI a controller designed in these units; its states stay."""
        rows, columns = self.u[:, None], 1 / self.y[None, :]
        return System(
            K.A / self.time,
            K.B * columns / self.time,
            rows * K.C,
            rows * K.D * columns,
        )

    def scaled(self, K: System) -> System:
        """Return a controller in SI in these units: the inverse of ``controller``."""
        rows, columns = 1 / self.u[:, None], self.y[None, :]
        return System(
            K.A * self.time,
            K.B * columns * self.time,
            rows * K.C,
            rows * K.D * columns,
        )


def suitable(
    plants: Sequence[GeneralisedPlant], time: float, gain: float = 1.0
) -> Coordinates:
    """Return units for plants that differ in ρ: D_12, D_21 of size one, A balanced.

    Args:
        plants: the plants of a grid.
        time: unit of time (s), about the inverse of the fastest frequency.
        gain: unit of the gain from w to z.
    """
    first, n = plants[0], plants[0].order
    root = np.sqrt(gain)
    u = root / np.linalg.norm(first.D_12, axis=0)
    y = np.linalg.norm(first.D_21, axis=1) / root
    plain = Coordinates(np.eye(n), time, u, y, gain)
    return replace(plain, T=np.diag(osborne([plain.plant(p) for p in plants])))


def osborne(plants: Sequence[GeneralisedPlant], sweeps: int = 100) -> Matrix:
    """Return state units (n,), powers of two, that balance all plants together.

    Rows of [A B] and columns of [A; C] get equal norms, the diagonal left out.
    """
    n = plants[0].order
    squares = np.zeros((2, n, n))
    rest = np.zeros((2, n))  # of rows: B; of columns: C
    for p in plants:
        squares += p.A**2
        rest[0] += np.sum(p.B_1**2, axis=1) + np.sum(p.B_2**2, axis=1)
        rest[1] += np.sum(p.C_1**2, axis=0) + np.sum(p.C_2**2, axis=0)
    M = squares[0]
    M[range(n), range(n)] = 0.0
    units = np.ones(n)
    for _ in range(sweeps):
        for i in range(n):
            row = np.sum(M[i] * units**2) / units[i] ** 2 + rest[0, i] / units[i] ** 2
            column = (np.sum(M[:, i] / units**2) + rest[1, i]) * units[i] ** 2
            if row > 0 and column > 0:
                units[i] *= (row / column) ** 0.25
    return np.asarray(2.0 ** np.rint(np.log2(units)))
