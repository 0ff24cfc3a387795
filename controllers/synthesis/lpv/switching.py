"""What controllers that hand over smoothly are designed for, in one or two parameters.

Each transition cuts its parameter's range in two: 2 local controllers for one, 4 for
two, numbered with the last parameter fastest.  Where two transitions meet, all four
are blended (6.51).

Source: Hanifzadegan 2014, sec. 6.1, 6.4, eq. 6.2, 6.36 to 6.38, 6.47 to 6.54.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controllers.synthesis.lpv.problem import Basis, PlantAt, Values
from controllers.synthesis.lpv.systems import Matrix
from controllers.synthesis.lpv.transition import share


class Transition(NamedTuple):
    """Where the parameter ``axis`` hands over, from ``low`` to ``high``."""

    axis: int
    low: float
    high: float

    def part(self, rho: Values) -> float:
        """Return s: 0 at the low end, 1 at the high."""
        return (rho[self.axis] - self.low) / (self.high - self.low)

    def inside(self, rho: Values, side: int) -> bool:
        """Tell whether the linear blend moves at ρ; ``side`` decides at an end."""
        s = self.part(rho)
        return 0 < s < 1 or (s == 0 and side > 0) or (s == 1 and side < 0)


class Sided(NamedTuple):
    """A value of ρ with one rate; ``sides`` ±1 tell which slope an end takes."""

    rho: Values
    rate: Values
    sides: tuple[int, ...]


@dataclass(frozen=True)
class Switching:
    """What a descent is told besides its start.

    ``K_basis`` gives f, ``P_basis`` p and its rates; the inequalities hold at
    ``points``, the bound of K's rate at all of them or, without ``everywhere``, where
    K is blended.  ``back_off`` is that of γ; P stays above ``least``, where the start's
    P is the unit.
    """

    plant: PlantAt
    transitions: tuple[Transition, ...]
    K_basis: Callable[[Values], Matrix]
    P_basis: Basis
    points: tuple[Sided, ...]
    decay: float
    back_off: float = 1.01
    least: float = 1e-4
    everywhere: bool = True

    def shares(self, rho: Values, free: tuple[float, ...]) -> Matrix:
        """Return the shares of all local controllers at ρ, with α's free numbers."""
        found: Matrix = np.ones(1)
        for transition, c in zip(self.transitions, free, strict=True):
            alpha = share(transition.part(rho), c)
            found = np.kron(found, [1 - alpha, alpha])
        return found

    def factors(self, point: Sided, time: float) -> tuple[Matrix, Matrix]:
        """Return the factors of all P_ik and their rates, per unit of time (s)."""
        rho, rate, sides = point
        shares: Matrix = np.ones(1)
        rates: Matrix = np.zeros(1)
        for transition, side in zip(self.transitions, sides, strict=True):
            s, moving = float(np.clip(transition.part(rho), 0.0, 1.0)), 0.0
            if transition.inside(rho, side):
                reach = transition.high - transition.low
                moving = time * rate[transition.axis] / reach
            here, change = np.array([1 - s, s]), np.array([-moving, moving])
            shares, rates = (
                np.kron(shares, here),
                np.kron(rates, here) + np.kron(shares, change),
            )
        values = self.P_basis.values(rho)
        slopes = time * self.P_basis.slopes(rho, rate)
        return np.kron(shares, values), np.kron(rates, values) + np.kron(shares, slopes)

    def bounded(self, points: Sequence[Sided]) -> tuple[Sided, ...]:
        """Return those of points where the rate of K is bounded (6.12, 6.55)."""
        return tuple(
            point
            for point in points
            if self.everywhere
            or any(
                transition.inside(point.rho, side)
                for transition, side in zip(self.transitions, point.sides, strict=True)
            )
        )


def both_sides(
    transition: Transition, below: Matrix, inside: Matrix, above: Matrix
) -> list[tuple[float, int]]:
    """Return values of a parameter with their sides; either end twice."""
    return [
        *((float(x), 0) for x in below),
        *((transition.low, side) for side in (-1, 1)),
        *((float(x), 0) for x in inside),
        *((transition.high, side) for side in (-1, 1)),
        *((float(x), 0) for x in above),
    ]
