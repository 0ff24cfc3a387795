"""What a gain-scheduled design is told: where it must hold and what may vary.

X is one matrix, Y(ρ) = Σ f_k(ρ) Y_k per region of the parameters.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np

from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix

Values: TypeAlias = tuple[float, ...]
PlantAt: TypeAlias = Callable[[Values], GeneralisedPlant]


class Point(NamedTuple):
    """A value of ρ and the vertices of its rate there (per s)."""

    rho: Values
    rates: tuple[Values, ...]


@dataclass(frozen=True)
class Basis:
    """The functions f_k: ``values(ρ)`` and ``slopes(ρ, ρ̇)``, their rates, (n,)."""

    values: Callable[[Values], Matrix]
    slopes: Callable[[Values, Values], Matrix]


@dataclass(frozen=True)
class Region:
    """The points where the inequalities are demanded, and the basis of Y."""

    points: tuple[Point, ...]
    basis: Basis


class Link(NamedTuple):
    """Y of region ``to`` may not exceed Y of ``of`` at ρ: one may switch there.

    The loop's storage function then does not rise when ``of`` hands over to ``to``.
    """

    of: int
    to: int
    rho: Values


@dataclass(frozen=True)
class Problem:
    """A gain-scheduled design: everything but its result.

    ``plant`` is in SI, ``Point.rates`` per second.  ``frozen`` are a few values of ρ,
    the ends among them, for the lower bound and the states.  ``time`` and ``gain`` are
    units for conditioning, ``floors`` as of ``frozen.balanced``, instead of which
    ``control_alone`` takes the states of ``frozen.of_control``.  ``decay`` (1/s) stays
    below the slowest weight's pole and about a quarter of the slowest loop's; γ is
    backed off by ``back_off`` and the traces of X and Y cost ``price``.  ``axes`` are
    the breakpoints of each region's table, sampled every ``T_s`` (s); with ``order``
    ρ is an angle and the table a Fourier series (``fourier``).
    """

    plant: PlantAt
    regions: tuple[Region, ...]
    frozen: tuple[Values, ...]
    axes: tuple[tuple[tuple[float, ...], ...], ...]
    T_s: float
    decay: float
    links: tuple[Link, ...] = ()
    back_off: float = 1.1
    price: float = 2e-3
    time: float = 1e-3
    gain: float = 1.0
    floors: tuple[float, float] = (0.0, 0.0)
    control_alone: bool = False
    order: int = 0


class Found(NamedTuple):
    """X (n, n) and the coefficients of a region's Y (k, n, n), valid at γ."""

    gamma: float
    X: Matrix
    Y: Matrix

    def at(self, factors: Matrix) -> Matrix:
        """Return Σ f_k Y_k."""
        return np.asarray(np.tensordot(factors, self.Y, axes=1))


def grid(*axes: Iterable[float], rates: Sequence[float]) -> tuple[Point, ...]:
    """Return all combinations of values; each parameter moves at ± its rate (per s)."""
    vertices = tuple(product(*({-abs(r), abs(r)} for r in rates)))
    return tuple(Point(rho, vertices) for rho in product(*axes))


def affine(centre: Sequence[float], half: Sequence[float]) -> Basis:
    """Return the basis 1, (ρ_i - centre_i)/half_i."""
    middle, width = np.array(centre), np.array(half)
    return Basis(
        lambda rho: np.concatenate([[1.0], (np.array(rho) - middle) / width]),
        lambda rho, rate: np.concatenate([[0.0], np.array(rate) / width]),
    )


def polynomial(centre: float, half: float, degree: int) -> Basis:
    """Return the basis 1, t, ..., t^degree of one parameter, t = (ρ - centre)/half."""
    powers = np.arange(degree + 1)

    def slopes(rho: Values, rate: Values) -> Matrix:
        t = (rho[0] - centre) / half
        steep = powers[1:] * t ** powers[:-1]
        return np.concatenate([[0.0], steep * rate[0] / half])

    return Basis(lambda rho: ((rho[0] - centre) / half) ** powers, slopes)
