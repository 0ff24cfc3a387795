"""Smooth switching of the serial machine's axis, by the source's descent.

Regions x_c <= 0.38 m and x_c >= 0.42 m; K and P affine in x_c.

Source: Hanifzadegan 2014, sec. 7.1.1.
"""

import numpy as np

from controllers.synthesis.lpv.design import Design
from controllers.synthesis.lpv.problem import polynomial
from controllers.synthesis.lpv.smooth import Smooth, begin
from controllers.synthesis.lpv.switching import (
    Sided,
    Switching,
    Transition,
    both_sides,
)
from controllers.synthesis.serial_lpv import single

LOW, HIGH = single.LOW, single.HIGH
TRANSITION = Transition(0, LOW, HIGH)
BELOW, INSIDE = (0.2, 0.245, 0.29, 0.335), (0.39, 0.4, 0.41)
ABOVE = (0.465, 0.51, 0.555, 0.6)
DECAY = 0.05  # 1/s


def problem(disturbance: float = single.UNDISTURBED) -> Switching:
    """Return what the descent is told; ``disturbance`` scales f."""
    return Switching(
        plant=single.plant(disturbance),
        transitions=(TRANSITION,),
        K_basis=lambda rho: np.array([1.0, (rho[0] - 0.4) / 0.2]),
        P_basis=polynomial(0.4, 0.2, 1),
        points=points(BELOW, INSIDE, ABOVE),
        decay=DECAY,
    )


def start(design: Design, disturbance: float = single.UNDISTURBED) -> Smooth:
    """Return step 0 from a single LPV design for the same ``disturbance``."""
    fits = [
        [(float(x),) for x in np.linspace(*ends, 21)]
        for ends in ((0.2, HIGH), (LOW, 0.6))
    ]
    return begin(problem(disturbance), design, (0.4,), fits)


def points(
    below: tuple[float, ...], inside: tuple[float, ...], above: tuple[float, ...]
) -> tuple[Sided, ...]:
    """Return positions with both slopes at either end of the transition, two rates."""
    positions = both_sides(TRANSITION, *map(np.array, (below, inside, above)))
    rates = (-single.SPEED, single.SPEED)
    return tuple(Sided((x,), (v,), (side,)) for x, side in positions for v in rates)


def dense() -> tuple[Sided, ...]:
    """Return the points on which a design is judged."""
    return points(
        tuple(np.linspace(0.2, 0.379, 41)),
        tuple(np.linspace(0.381, 0.419, 15)),
        tuple(np.linspace(0.421, 0.6, 41)),
    )
