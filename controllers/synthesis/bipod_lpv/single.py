"""One LPV controller K(φ, ẋ_1) for the bipod's slider T1, e = r - x_1 → f_1.

    w = (r, f_d),   z = (W_e e, W_v f_1),   y = e,   f_1 = H_1(φ) ν

Designed for ν: with the inertia divided out the plant is nearly a double integrator
and a constant X costs nothing.  φ̇ = -ẋ_1/(2L_s cos φ) is no free rate; the plant is
affine in ẋ_1, Y = Y_0 + Y_1 t + Y_2 t² with t = tan²φ/33.

``on_nu`` weighs ν with W_v m_0 instead of f_1: the printed weights bound the force
where it is largest, and give the smallest γ, not the smallest error.

Source: Hanifzadegan 2014, sec. 7.2, eq. 7.11 to 7.17.
"""

from dataclasses import dataclass, replace

import numpy as np

from controllers.synthesis.lpv.problem import (
    Basis,
    Link,
    Point,
    Problem,
    Region,
    Values,
)
from controllers.synthesis.lpv.systems import GeneralisedPlant, System
from controllers.synthesis.lpv.weights import rational
from plants.bipod._mechanism import Links, convective, damping, inertia

W_E = ((1.0, 3359.0, 3.76e6, 1.40e9), (1.13, 134.0, 5325.0, 7.01e4))
PHI_DEG = (10.0, 40.0, 55.0, 63.0, 68.0, 70.01, 72.7, 75.39, 77.0, 78.5, 79.3, 80.0)
TABLE_DEG = tuple(float(x) for x in np.linspace(10.0, 80.0, 57))
LOW_DEG, HIGH_DEG = 70.0, 75.4  # where two controllers meet
FIRST_DEG = (
    *(10.0, 18.0, 25.0, 32.0, 40.0, 45.0, 50.0, 54.0, 58.0, 61.0, 63.0, 65.0, 66.5),
    *(68.0, 69.0, 70.0, 71.5, 73.0, 74.3, 75.4),
)
FIRST_TABLE_DEG = (10.0, 40.0, 54.0, 61.0, 65.0, 68.0, 70.0, 73.0, 75.4)
SECOND_DEG = (70.0, 71.5, 73.0, 74.3, 75.4, 77.0, 78.5, 79.3, 80.0)
SPEED = 1.0  # m/s
SCALE = 33.0  # of tan²φ: about its value at 80 degrees
M_0 = 60.0  # kg, a middle inertia: ν is measured in W_v m_0
T_S = 1e-4  # s


@dataclass(frozen=True)
class Weights:
    """W_v (1/N), weight of f_d, and whether W_v m_0 weighs ν instead of W_v f_1."""

    W_v: float = 1e-5
    W_d: float = 1.0
    on_nu: bool = False


PRINTED = Weights()
TUNED = Weights(W_v=0.6e-5, W_d=1e5, on_nu=True)


def problem(
    weights: Weights = PRINTED,
    phi_deg: tuple[float, ...] = PHI_DEG,
    decay: float = 0.5,
    links: Links | None = None,
) -> Problem:
    """Return the design problem; ρ is (φ, ẋ_1) in rad and m/s.

    Args:
        weights: as above.
        phi_deg: angles of the design's grid (deg).
        decay: margin (1/s).
        links: the mechanism, Table 7.1 if None.
    """
    p = Links() if links is None else links
    phi = tuple(float(np.deg2rad(value)) for value in phi_deg)
    # with the printed weights K has poles at 1e5 rad/s, which bend between angles
    table = phi if weights.on_nu else tuple(map(float, np.deg2rad(TABLE_DEG)))
    return Problem(
        plant=lambda rho: plant(rho, weights, p),
        regions=(Region(tied(phi, p), BASIS),),
        frozen=tuple((phi[k], v) for k in (0, len(phi) // 2, -1) for v in (-1.0, 1.0)),
        axes=((table, (-SPEED, SPEED)),),
        T_s=T_S,
        decay=decay,
        back_off=1.05,
        price=1e-5,
        time=1e-2,
        gain=150.0,
        floors=(1e-2, 1e-2),
    )


def calibrated() -> Problem:
    """Return the problem whose design has the published errors, near enough.

    γ leaves Y free at small angles, where the error without f_d is largest: the price
    of the traces decides it.
    """
    return replace(problem(TUNED), back_off=1.04, price=2e-4)


def hysteresis(
    weights: Weights = PRINTED, decay: float = 0.5, links: Links | None = None
) -> Problem:
    """Return the problem of two controllers with hysteresis between 70 and 75.4 deg.

    Regions reach over the transition; the first hands over at its upper end, the
    second at its lower.  γ is loose below 63 deg, so Y may bend there: the first
    region needs its points close, its table does not.  Arguments as of ``problem``.
    """
    p = Links() if links is None else links
    single = problem(weights, PHI_DEG, decay, links)
    low, high = float(np.deg2rad(LOW_DEG)), float(np.deg2rad(HIGH_DEG))
    reach, tables = (
        [tuple(float(x) for x in np.deg2rad(angles)) for angles in both]
        for both in ((FIRST_DEG, SECOND_DEG), (FIRST_TABLE_DEG, SECOND_DEG))
    )
    switches = [Link(0, 1, (high, 0.0)), Link(1, 0, (low, 0.0))]
    return replace(
        single,
        regions=tuple(Region(tied(angles, p), BASIS) for angles in reach),
        axes=tuple((angles, (-SPEED, SPEED)) for angles in tables),
        links=tuple(switches),
    )


def plant(rho: Values, weights: Weights, p: Links) -> GeneralisedPlant:
    """Return the generalised plant at (φ, ẋ_1); u = W_v m_0 ν."""
    (phi, v), W = rho, W_E_SYSTEM
    t = np.tan(phi)
    H = inertia(t, p)
    friction = -(damping(t, p) + convective(t, p) * v) / H
    n = len(W.A)
    G_A = np.array([[0.0, 1.0], [0.0, friction]])
    C = np.array([[1.0, 0.0]])
    effort = 1.0 if weights.on_nu else H / M_0
    return GeneralisedPlant(
        A=np.block([[G_A, np.zeros((2, n))], [-W.B @ C, W.A]]),
        B_1=np.block(
            [
                [np.zeros((2, 1)), np.array([[0.0], [weights.W_d * t / (2 * H)]])],
                [W.B, np.zeros((n, 1))],
            ]
        ),
        B_2=np.array([[0.0], [1 / (weights.W_v * M_0)], *[[0.0]] * n]),
        C_1=np.vstack([np.hstack([-W.D @ C, W.C]), np.zeros((1, n + 2))]),
        C_2=np.hstack([-C, np.zeros((1, n))]),
        D_11=np.array([[W.D[0, 0], 0.0], [0.0, 0.0]]),
        D_12=np.array([[0.0], [effort]]),
        D_21=np.array([[1.0, 0.0]]),
    )


def tied(
    phi: tuple[float, ...], p: Links, speeds: tuple[float, ...] = (-SPEED, SPEED)
) -> tuple[Point, ...]:
    """Return points with the rate of φ (rad/s) that each speed (m/s) means."""
    return tuple(
        Point((angle, v), ((-v / (2 * p.L_s * np.cos(angle)), 0.0),))
        for angle in phi
        for v in speeds
    )


def dense(
    n: int = 71, ends_deg: tuple[float, float] = (10.0, 80.0)
) -> tuple[Point, ...]:
    """Return the grid on which a design is judged, two speeds at each of n angles."""
    return tied(tuple(np.deg2rad(np.linspace(*ends_deg, n))), Links())


def _values(rho: Values) -> np.ndarray:
    t = np.tan(rho[0]) ** 2 / SCALE
    return np.array([1.0, t, t * t])


def _slopes(rho: Values, rate: Values) -> np.ndarray:
    tangent = np.tan(rho[0])
    t = tangent**2 / SCALE
    t_rate = 2 * tangent * (1 + tangent**2) / SCALE * rate[0]
    return np.array([0.0, t_rate, 2 * t * t_rate])


BASIS = Basis(_values, _slopes)
W_E_SYSTEM: System = rational(*W_E)
