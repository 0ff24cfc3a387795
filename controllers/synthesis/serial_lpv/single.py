"""LPV control K(x_c) for an axis of the serial machine, e = r - u_c → v_m.

    w = (f, r),   z = (W_e e, W_v v_m),   y = e,   f_c = W_f f

on the plant of Table 3.3.  The published γ of 13 lies below the H-infinity optimum of
the frozen plant, with the disturbance (23.8) and without it (15.5): no controller can
reach it with the printed data.

Source: Hanifzadegan 2014, sec. 7.1, eq. 7.1 to 7.3; motor force per volt with the
printed r_g = 0.0032 m/rad.
"""

from dataclasses import replace

import numpy as np

from controllers.synthesis.ball_screw_lpv.plants import over_x
from controllers.synthesis.lpv.problem import (
    Link,
    PlantAt,
    Problem,
    Region,
    Values,
    grid,
    polynomial,
)
from controllers.synthesis.lpv.systems import GeneralisedPlant
from controllers.synthesis.lpv.weights import rational

VOLT = 0.72 * 0.887 / 0.0032  # N/V
W_V = 7e-4
W_F = ((1.66e8, 0.47e8), (1.0, 1.59e4))
W_E = ((1.0, 1153.0, 3.32e5), (1.58, 1.948, 0.59))
UNDISTURBED = 1e-2  # scale of f where it is left out: the problem stays regular
POINTS = (0.2, 0.3, 0.4, 0.5, 0.6)  # m
LOW, HIGH = 0.38, 0.42  # m, where two controllers meet
FIRST, SECOND = (0.2, 0.255, 0.31, 0.365, HIGH), (LOW, 0.435, 0.49, 0.545, 0.6)
STEP = 0.02  # m, of the tables: kinks of coarser ones show in the error
SPEED = 0.45  # m/s
T_S = 9 / 25_000  # s
TIME = 1e-2  # s, unit for conditioning


def problem(
    disturbance: float = UNDISTURBED,
    W_v: float = W_V,
    points: tuple[float, ...] = POINTS,
    decay: float = 0.05,
) -> Problem:
    """Return the design problem over x_c.

    Args:
        disturbance: scale of f, 1 as printed.
        W_v: weight on the command (1/V).
        points: nut positions (m) of the design.
        decay: margin (1/s), below the slowest poles of W_e, 0.62 rad/s.
    """
    return Problem(
        plant=plant(disturbance, W_v),
        regions=(Region(grid(points, rates=[SPEED]), polynomial(0.4, 0.2, 1)),),
        frozen=((points[0],), (points[len(points) // 2],), (points[-1],)),
        axes=((table(points),),),
        T_s=T_S,
        decay=decay,
        price=1e-5 if disturbance == 1 else 1e-3,  # else the solver stops
        time=TIME,
        floors=(1e-2, 1e-2),
    )


def hysteresis(disturbance: float = UNDISTURBED) -> Problem:
    """Return the problem of two controllers with hysteresis between 0.38 and 0.42 m.

    Regions reach over the transition; the first hands over at its upper end, the
    second at its lower.  ``disturbance`` as of ``problem``.
    """
    single = problem(disturbance)
    reach = (FIRST, SECOND)
    return replace(
        single,
        regions=tuple(
            Region(grid(points, rates=[SPEED]), single.regions[0].basis)
            for points in reach
        ),
        axes=tuple((table(points),) for points in reach),
        links=(Link(0, 1, (HIGH,)), Link(1, 0, (LOW,))),
        price=1e-4,  # a higher one gives poles too fast for the table
    )


def table(points: tuple[float, ...]) -> tuple[float, ...]:
    """Return the table's breakpoints (m) over the reach of a design's points."""
    count = round((points[-1] - points[0]) / STEP) + 1
    return tuple(float(x) for x in np.linspace(points[0], points[-1], count))


def plant(disturbance: float = 1.0, W_v: float = W_V) -> PlantAt:
    """Return the generalised plant over (x_c,); arguments as of ``problem``."""
    W, F = rational(*W_E), rational(*W_F)
    k = len(W.A)

    def at(rho: Values) -> GeneralisedPlant:
        G, zero = over_x(rho[0]), np.zeros
        n, force = len(G.A), disturbance * G.B[:, [1]]
        C_c = G.C[[1]]
        return GeneralisedPlant(
            A=np.block(
                [
                    [G.A, force @ F.C, zero((n, k))],
                    [zero((1, n)), F.A, zero((1, k))],
                    [-W.B @ C_c, zero((k, 1)), W.A],
                ]
            ),
            B_1=np.block(
                [
                    [force @ F.D, zero((n, 1))],
                    [F.B, zero((1, 1))],
                    [zero((k, 1)), W.B],
                ]
            ),
            B_2=np.vstack([VOLT * G.B[:, [0]], zero((k + 1, 1))]),
            C_1=np.vstack(
                [np.hstack([-W.D @ C_c, [[0.0]], W.C]), zero((1, n + k + 1))]
            ),
            C_2=np.hstack([-C_c, zero((1, k + 1))]),
            D_11=np.array([[0.0, W.D[0, 0]], [0.0, 0.0]]),
            D_12=np.array([[0.0], [W_v]]),
            D_21=np.array([[0.0, 1.0]]),
        )

    return at
