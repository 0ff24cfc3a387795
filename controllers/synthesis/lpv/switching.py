"""What two controllers that hand over smoothly are designed for.

Source: Hanifzadegan 2014, sec. 6.1, eq. 6.2, 6.36 to 6.38.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from controllers.synthesis.lpv.problem import Basis, PlantAt, Values
from controllers.synthesis.lpv.systems import Matrix


class Sided(NamedTuple):
    """A value of ρ with one rate; ``side`` ±1 tells which slope an end takes."""

    rho: Values
    rate: Values
    side: int = 0


@dataclass(frozen=True)
class Switching:
    """What a descent is told besides its start.

    The first parameter switches between ``low`` and ``high``; ``K_basis`` gives f,
    ``P_basis`` p and its rates; the inequalities hold at ``points``.  ``back_off`` is
    that of γ; P stays above ``least``, where the start's P is the unit.
    """

    plant: PlantAt
    low: float
    high: float
    K_basis: Callable[[Values], Matrix]
    P_basis: Basis
    points: tuple[Sided, ...]
    decay: float
    back_off: float = 1.01
    least: float = 1e-4
