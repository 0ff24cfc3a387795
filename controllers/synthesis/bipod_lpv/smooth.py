"""Smooth switching between two LPV controllers of the bipod, by the source's descent.

Regions φ <= 70 deg and φ >= 75.4 deg; K over {1, t, t², t³, t ẋ_1}, P over {1, t, t²},
t = tan²φ/33.  Plant and P's rate are affine in ẋ_1, and so is K: ẋ_1 = ±1 m/s suffice.

Source: Hanifzadegan 2014, sec. 7.2.4, eq. 7.18 to 7.21.
"""

import numpy as np

from controllers.synthesis.bipod_lpv import single
from controllers.synthesis.lpv.design import Design
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.smooth import Smooth, begin
from controllers.synthesis.lpv.switching import (
    Sided,
    Switching,
    Transition,
    both_sides,
)
from controllers.synthesis.lpv.systems import Matrix
from plants.bipod._mechanism import Links

LOW_DEG, HIGH_DEG = single.LOW_DEG, single.HIGH_DEG
UNIT = (float(np.deg2rad(72.0)), 1.0)  # ρ whose storage function is the unit
BELOW_DEG = (10.0, 25.0, 40.0, 50.0, 58.0, 63.0, 66.0, 67.0, 68.0, 69.0)
INSIDE, ABOVE = 9, 9  # points of the design within and beyond the transition
DECAY = 1.0  # 1/s
TRANSITION = Transition(0, float(np.deg2rad(LOW_DEG)), float(np.deg2rad(HIGH_DEG)))


def problem(weights: single.Weights = single.PRINTED) -> Switching:
    """Return what the descent is told; calibrated weights need more room per step."""
    p, printed = Links(), weights == single.PRINTED
    return Switching(
        plant=lambda rho: single.plant(rho, weights, p),
        transitions=(TRANSITION,),
        K_basis=_K_basis,
        P_basis=single.BASIS,
        points=points(BELOW_DEG, INSIDE, ABOVE),
        decay=DECAY,
        back_off=1.01 if printed else 1.03,
        least=1e-4 if printed else 1e-2,
    )


def start(design: Design, weights: single.Weights = single.PRINTED) -> Smooth:
    """Return step 0 from the single LPV design of the same weights."""
    fits = [
        [
            (float(phi), v)
            for phi in np.deg2rad(np.linspace(*ends, 40))
            for v in (-1.0, 1.0)
        ]
        for ends in ((10.0, HIGH_DEG), (LOW_DEG, 80.0))
    ]
    return begin(problem(weights), design, UNIT, fits)


def points(below_deg: tuple[float, ...], inside: int, above: int) -> tuple[Sided, ...]:
    """Return angles with both slopes at either end of the transition, ẋ_1 = ±1 m/s."""
    low, high = TRANSITION.low, TRANSITION.high
    between = np.linspace(low, high, inside + 2)[1:-1]
    beyond = np.linspace(high, np.deg2rad(80.0), above + 1)[1:]
    angles = both_sides(TRANSITION, np.deg2rad(below_deg), between, beyond)
    return tuple(_sided(phi, v, side) for phi, side in angles for v in (-1, 1))


def dense() -> tuple[Sided, ...]:
    """Return the points on which a design is judged."""
    return points(tuple(np.linspace(10.0, 69.0, 60)), 23, 20)


def _sided(phi: float, v: float, side: int) -> Sided:
    rate = -v / (2 * Links().L_s * np.cos(phi))
    return Sided((phi, float(v)), (float(rate), 0.0), (side,))


def _K_basis(rho: Values) -> Matrix:
    t = np.tan(rho[0]) ** 2 / single.SCALE
    return np.array([1.0, t, t * t, t**3, t * rho[1]])
