"""K_vib(x_c): vibration controller, y = u_m - u_c → v_v, by gridded inequalities.

    w = (f_c, n),   z = (W_f u_c, W_v v_v),   y = u_m - u_c + ε n

around the plant of Table 3.3 that K_track already controls.  Repairs of the source:
y is the difference of the positions (with both as printed the controller has a gain
on absolute position and 50 dB of tracking are lost); ε is the encoder's resolution
(without, the problem is singular); W_f has a corner at ω_b, as drawn, where (4.13)
with both gains below 0 dB has no crossing; the run-out is left out of the design.

Source: Hanifzadegan 2014, sec. 4.3.2, 4.3.3, 4.4.2, eq. 4.3 to 4.12, Table 4.1.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from controllers.synthesis.ball_screw_lpv.plants import (
    MOTOR,
    TABLE,
    VOLT,
    over_x,
    part,
)
from controllers.synthesis.lpv.problem import (
    Basis,
    Point,
    Problem,
    Region,
    affine,
    grid,
)
from controllers.synthesis.lpv.systems import GeneralisedPlant, System
from controllers.synthesis.lpv.weights import corner, decibels

W_F = (decibels(-110), decibels(-175), 6.0)  # M_L, M_H (m/N), ω_b (rad/s)
W_V = 100.0  # 1/V
EPS = 1e-7  # m
GRID = (0.2, 0.3, 0.4, 0.5, 0.6)  # m
SPEED = 0.48  # m/s
DECAY = 4.0  # 1/s
T_S = 9 / 25_000  # s
BASIS = affine([0.4], [0.2])


def problem(
    K_track: System,
    W_f: tuple[float, float, float] = W_F,
    W_v: float = W_V,
    eps: float = EPS,
    points: Sequence[float] = GRID,
    basis: Basis = BASIS,
    decay: float = DECAY,
) -> Problem:
    """Return the design problem.

    Args:
        K_track: the tracking controller, continuous, u_c - r → -v_t is closed.
        W_f: M_L, M_H (m/N) and ω_b (rad/s) of the weight on u_c.
        W_v: weight on the command (1/V).
        eps: noise of the measured difference (m).
        points: nut positions (m) of design and table.
        basis: functions of Y(x_c).
        decay: margin (1/s).
    """
    plant = around(lambda rho: over_x(rho[0]), K_track, W_f, W_v, eps)
    ends = (points[0],), (points[len(points) // 2],), (points[-1],)
    return Problem(
        plant=plant,
        regions=(Region(grid(points, rates=[SPEED]), basis),),
        frozen=ends,
        axes=((halved(points),),),
        T_s=T_S,
        decay=decay,
    )


def halved(points: Sequence[float]) -> tuple[float, ...]:
    """Return points and their middles: with points alone a table loses 0.06 um."""
    middles = [(a + b) / 2 for a, b in pairwise(points)]
    return tuple(float(x) for x in sorted([*points, *middles]))


def dense(n: int = 201, stroke: tuple[float, float] = (0.2, 0.6)) -> tuple[Point, ...]:
    """Return the grid on which a design is judged, two rates at each of n points."""
    return grid(np.linspace(*stroke, n), rates=[SPEED])


def around(
    plant: Callable[[tuple[float, ...]], System],
    K_track: System,
    W_f: tuple[float, float, float],
    W_v: float,
    eps: float,
) -> Callable[[tuple[float, ...]], GeneralisedPlant]:
    """Return the generalised plant at ρ for any plant (f_m, f_c) → (u_m, u_c)."""
    W = corner(*W_f)

    def at(rho: tuple[float, ...]) -> GeneralisedPlant:
        G = tracked(plant(rho), K_track)
        n = len(G.A)
        C_c, zero = part(G, TABLE, MOTOR).C, np.zeros
        return GeneralisedPlant(
            A=np.block([[G.A, zero((n, 1))], [W.B @ C_c, W.A]]),
            B_1=np.block([[G.B[:, [1]], zero((n, 1))], [zero((1, 2))]]),
            B_2=np.vstack([VOLT * G.B[:, [0]], zero((1, 1))]),
            C_1=np.vstack([np.hstack([W.D @ C_c, W.C]), zero((1, n + 1))]),
            C_2=np.hstack([G.C[[0]] - C_c, zero((1, 1))]),
            D_11=zero((2, 2)),
            D_12=np.array([[0.0], [W_v]]),
            D_21=np.array([[0.0, eps]]),
        )

    return at


def tracked(G: System, K: System) -> System:
    """Return (f_m, f_c) → (u_m, u_c) with K_track closed, r = 0; K's states last."""
    C_c, B_m = G.C[[1]], VOLT * G.B[:, [0]]
    k = len(K.A)
    return System(
        np.block([[G.A - B_m @ K.D @ C_c, B_m @ K.C], [-K.B @ C_c, K.A]]),
        np.vstack([G.B, np.zeros((k, 2))]),
        np.hstack([G.C, np.zeros((2, k))]),
        np.zeros((2, 2)),
    )
