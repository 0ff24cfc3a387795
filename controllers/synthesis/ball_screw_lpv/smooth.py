"""K_vib(x_c, m_wor) of four controllers that hand over smoothly in two parameters.

Regions x_c <= 0.38 m and x_c >= 0.42 m, m_wor <= 4 kg and m_wor >= 6 kg: nine
rectangles, of which five blend two or four controllers.  The workpiece loses or gains
up to half a kilogram per second.  The start is the design of one region, P is its
own; the mass enters as 1/J_e and ω²: K takes its cube.

Source: Hanifzadegan 2014, sec. 6.4, eq. 6.47 to 6.59, on the problem of sec. 5.2.1.
"""

from itertools import product

import numpy as np

from controllers.synthesis.ball_screw_lpv import switching
from controllers.synthesis.ball_screw_lpv.k_vib import SPEED
from controllers.synthesis.lpv.design import Design
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.smooth import Smooth, begin
from controllers.synthesis.lpv.switching import Sided, Switching, Transition
from controllers.synthesis.lpv.systems import Matrix

TRANSITIONS = (Transition(0, 0.38, 0.42), Transition(1, 4.0, 6.0))
ENDS = ((0.2, 0.6), (0.0, 10.0))  # m, kg
MASS_RATE = 0.5  # kg/s
MIDDLE = (0.4, 5.0)  # ρ whose storage function is the unit of the states
POSITIONS = (0.2, 0.29, 0.38, 0.39, 0.4, 0.41, 0.42, 0.51, 0.6)  # m
MASSES = (0.0, 2.0, 4.0, 4.5, 5.0, 5.5, 6.0, 8.0, 10.0)  # kg
FITTED = 9  # values of either parameter, in each region


def problem(start: Design) -> Switching:
    """Return what the descent is told; the plant is the start's."""
    return Switching(
        plant=start.problem.plant,
        transitions=TRANSITIONS,
        K_basis=_K_basis,
        P_basis=switching.BASIS,
        points=points(POSITIONS, MASSES),
        decay=start.problem.decay,
        everywhere=False,
    )


def start(design: Design) -> Smooth:
    """Return step 0 from the design of one region: four controllers, fitted."""
    halves = [
        [np.linspace(low, t.high, FITTED), np.linspace(t.low, high, FITTED)]
        for t, (low, high) in zip(TRANSITIONS, ENDS, strict=True)
    ]
    fits = [
        [(float(x), float(m)) for x in positions for m in masses]
        for positions, masses in product(*halves)
    ]
    return begin(problem(design), design, MIDDLE, fits)


def points(
    positions: tuple[float, ...] | Matrix, masses: tuple[float, ...] | Matrix
) -> tuple[Sided, ...]:
    """Return all combinations with the vertices of their rates.

    The start's P has no kinks: an end needs one side.
    """
    vertices = list(product((-SPEED, SPEED), (-MASS_RATE, MASS_RATE)))
    return tuple(
        Sided((float(x), float(m)), rate, (0, 0))
        for x, m in product(positions, masses)
        for rate in vertices
    )


def dense(n: int = 33, masses: int = 17) -> tuple[Sided, ...]:
    """Return the points on which a design is judged."""
    return points(*(np.linspace(*e, k) for e, k in zip(ENDS, (n, masses), strict=True)))


def _K_basis(rho: Values) -> Matrix:
    x, m = (rho[0] - 0.4) / 0.2, (rho[1] - 5.0) / 5.0
    return np.array([1.0, x, m, x * x, x * m, m * m, m**3, x * m * m, x * x * m])
