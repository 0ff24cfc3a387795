"""Contouring in the plane: one LPV controller over the path's direction θ.

    w = (r, f),   z = (W_t e_t, W_n e_n, W_v u),   (e_t, e_n) = T(θ)(r - C x)

The controller reads r - C x instead of T(θ)(r - C x): it knows θ and can undo T.
Then C_2 is constant and D_21 = [I 0], the inequality of X does not depend on θ, and a
constant X costs nothing.  f enters at the motors; it gives the estimator a problem to
solve.  θ wraps: it enters by cos θ and sin θ alone.

Source: Hanifzadegan 2014, sec. 8.2, 8.4, eq. 8.5 (printed with a row that is no
rotation), 8.13 to 8.16 (D_21 printed as zero), Table 8.3.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from controllers.synthesis.lpv.problem import (
    Basis,
    PlantAt,
    Point,
    Problem,
    Region,
    Values,
    grid,
)
from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix, System
from controllers.synthesis.lpv.weights import decibels, shelf
from plants.three_axis._axes import Axis, X, Y, modes

W_T = (decibels(-94), decibels(1), 1250.0, 2)  # M_L, M_H, ω_b (rad/s), k
W_N = (decibels(-128), decibels(1), 6970.0, 3)
W_V = 0.0135  # 1/V
W_F = 4.2e5  # N
TURN = 11.0  # rad/s, largest rate of θ
FASTEST = 1000.0  # rad/s: modes beyond are left out of the design
T_S = 1 / 4000  # s
ORDER = 4  # harmonics of the table
PRICE = 4.5e-8  # of the traces: more makes smaller errors and loses the certificate
BASIS = Basis(
    lambda rho: np.array([1.0, np.cos(rho[0]), np.sin(rho[0])]),
    lambda rho, rate: rate[0] * np.array([0.0, -np.sin(rho[0]), np.cos(rho[0])]),
)


def problem(points: int = 8, W_v: float = W_V, decay: float = 1.5) -> Problem:
    """Return the design problem over θ (rad).

    Args:
        points: angles of the design's grid, evenly around.
        W_v: weight on either command (1/V).
        decay: margin (1/s), below the slowest weight's pole, 5.58 rad/s.
    """
    angles = tuple(float(a) for a in 2 * np.pi * np.arange(points) / points)
    return Problem(
        plant=plant(W_v),
        regions=(Region(grid(angles, rates=[TURN]), BASIS),),
        frozen=tuple((angle,) for angle in angles),
        axes=((),),
        T_s=T_S,
        decay=decay,
        back_off=1.05,
        price=PRICE,
        order=ORDER,
        time=1 / 300,
        gain=3e4,
        control_alone=True,
    )


def plant(W_v: float = W_V, fastest: float = FASTEST) -> PlantAt:
    """Return the generalised plant over (θ,).

    Args:
        W_v: weight on either command (1/V).
        fastest: modes beyond (rad/s) are left out; inf keeps them.
    """
    axes = [axis_model(axis, fastest) for axis in (X, Y)]
    G = beside(axes)
    W = beside([shelf(*W_T), shelf(*W_N)])
    n, k = len(G.A), len(W.A)
    force = np.diag([W_F * a.p_t / (2 * np.pi) / (a.k_t * a.k_a) for a in (X, Y)])
    zero = np.zeros

    def at(rho: Values) -> GeneralisedPlant:
        T = rotation(rho[0])
        into, through = W.B @ T, W.D @ T
        return GeneralisedPlant(
            A=np.block([[G.A, zero((n, k))], [-into @ G.C, W.A]]),
            B_1=np.block([[zero((n, 2)), G.B @ force], [into, zero((k, 2))]]),
            B_2=np.vstack([G.B, zero((k, 2))]),
            C_1=np.block([[-through @ G.C, W.C], [zero((2, n + k))]]),
            C_2=np.hstack([-G.C, zero((2, k))]),
            D_11=np.block([[through, zero((2, 2))], [zero((2, 4))]]),
            D_12=np.vstack([zero((2, 2)), W_v * np.eye(2)]),
            D_21=np.hstack([np.eye(2), zero((2, 2))]),
        )

    return at


def rotation(theta: float) -> Matrix:
    """Return T, which turns x and y into the tangent and the normal (eq. 8.5)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, s], [-s, c]])


def axis_model(axis: Axis, fastest: float) -> System:
    """Return an axis in real modal blocks, command (V) to position (m)."""
    found = modes(axis)
    blocks = []
    for pole, residue in zip(*found, strict=True):
        if abs(pole) > fastest or pole.imag < 0:
            continue
        if pole.imag == 0:
            A, B, C = [[pole.real]], [[1.0]], [[residue.real]]
        else:
            s, w = pole.real, pole.imag
            A, B = [[s, w], [-w, s]], [[1.0], [0.0]]
            C = [[2 * residue.real, 2 * residue.imag]]
        blocks.append(System(*map(np.array, (A, B, C, [[0.0]]))))
    parallel = beside(blocks)
    n = len(blocks)
    return System(
        parallel.A,
        parallel.B @ np.ones((n, 1)),
        np.ones((1, n)) @ parallel.C,
        np.zeros((1, 1)),
    )


def beside(systems: Sequence[System]) -> System:
    """Return systems that do not see each other as one."""
    return System(*(block_diag(*parts) for parts in zip(*systems, strict=True)))


def dense(n: int = 181) -> tuple[Point, ...]:
    """Return the grid on which a design is judged, two rates at each of n angles."""
    return grid(np.linspace(0, 2 * np.pi, n), rates=[TURN])
