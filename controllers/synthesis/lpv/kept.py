"""What X and Y that a solver found do keep; no solver is asked."""

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates
from controllers.synthesis.lpv.inequalities import coupling, gain_of_x, gain_of_y
from controllers.synthesis.lpv.problem import Found, Point, Problem, Region


def kept_gain(
    problem: Problem,
    units: Coordinates,
    region: Region,
    found: Found,
    points: tuple[Point, ...],
    decay: float = 0.0,
) -> float:
    """Return the least γ, in ``units``, that X and Y keep at points; inf if none.

    ``decay`` (1/s) is the margin that the inequalities are asked with.
    """
    decay, worst = decay * units.time, 0.0
    for point in points:
        plant = units.plant(problem.plant(point.rho))
        Y = found.at(region.basis.values(point.rho))
        # at the optimum [X I; I Y] is singular: a solver's rounding is no refusal
        rounding = max(1e-6, 1e-9 * float(np.trace(found.X) + np.trace(Y)))
        if coupling(found.X, Y) < -rounding:
            return float("inf")
        worst = max(worst, gain_of_x(plant, found.X, decay))
        for rate in point.rates:
            moving = found.at(units.time * region.basis.slopes(point.rho, rate))
            worst = max(worst, gain_of_y(plant, Y, moving, decay))
    return worst
