"""K_vib scheduled by position and mass, on one region or switched between two.

The problem of ``k_vib`` on the plant of Table 3.4.  Regions x_c ≤ 0.27 m and
x_c ≥ 0.25 m share X, so controllers share their state, and the Y's are ordered on
both switching surfaces: one may leave the first region at 0.27 m and return at
0.25 m.  The mass enters as 1/J_e and ω²: what holds at 0, 5, 10 kg fails between.

As printed (tracking and vibration in one controller, w at the inputs) the problem
has no useful solution: the range of W_r alone is 1e7 (docs/studies/ball_screw_lpv.md).
Source: Hanifzadegan 2014, sec. 5.1, 5.2.1, eq. 5.4 to 5.8.
"""

import numpy as np

from controllers.synthesis.ball_screw_lpv.k_vib import (
    EPS,
    SPEED,
    T_S,
    W_F,
    W_V,
    around,
)
from controllers.synthesis.ball_screw_lpv.plants import over_x_and_mass
from controllers.synthesis.lpv.problem import (
    Link,
    Point,
    Problem,
    Region,
    affine,
    grid,
)
from controllers.synthesis.lpv.systems import System

MASSES = (0.0, 2.5, 5.0, 7.5, 10.0)  # kg
WHOLE = (0.2, 0.3, 0.4, 0.5, 0.6)  # m
FIRST, SECOND = (0.2, 0.235, 0.27), (0.25, 0.34, 0.425, 0.51, 0.6)
LEAVE, RETURN = 0.27, 0.25  # m
MASS_RATE = 0.0  # kg/s: the workpiece changes slowly
PRICE = 1e-5  # of the traces: more costs 2 dB of damping at 10 kg
BASIS = affine([0.4, 5.0], [0.2, 5.0])


def two_regions(
    K_track: System,
    W_f: tuple[float, float, float] = W_F,
    W_v: float = W_V,
    eps: float = EPS,
    decay: float = 5.0,
) -> Problem:
    """Return the problem of the switched controller; arguments as of ``k_vib``."""
    links = [Link(0, 1, (LEAVE, m)) for m in MASSES]
    links += [Link(1, 0, (RETURN, m)) for m in MASSES]
    return Problem(
        plant=around(lambda rho: over_x_and_mass(*rho), K_track, W_f, W_v, eps),
        regions=tuple(_region(points) for points in (FIRST, SECOND)),
        frozen=_ends(),
        axes=((FIRST, MASSES), (SECOND, MASSES)),
        T_s=T_S,
        decay=decay,
        links=tuple(links),
        price=PRICE,
    )


def one_region(
    K_track: System,
    W_f: tuple[float, float, float] = W_F,
    W_v: float = W_V,
    eps: float = EPS,
    decay: float = 3.0,
) -> Problem:
    """Return the problem without switching; arguments as of ``k_vib``."""
    return Problem(
        plant=around(lambda rho: over_x_and_mass(*rho), K_track, W_f, W_v, eps),
        regions=(_region(WHOLE),),
        frozen=_ends(),
        axes=((WHOLE, MASSES),),
        T_s=T_S,
        decay=decay,
        price=PRICE,
    )


def dense(low: float, high: float, n: int = 41, masses: int = 11) -> tuple[Point, ...]:
    """Return a grid between two nut positions (m) over all masses."""
    positions, kilograms = np.linspace(low, high, n), np.linspace(0, 10, masses)
    return grid(positions, kilograms, rates=[SPEED, MASS_RATE])


def _region(points: tuple[float, ...]) -> Region:
    return Region(grid(points, MASSES, rates=[SPEED, MASS_RATE]), BASIS)


def _ends() -> tuple[tuple[float, float], ...]:
    return tuple((x_c, m) for x_c in (0.2, 0.6) for m in (0.0, 10.0))
