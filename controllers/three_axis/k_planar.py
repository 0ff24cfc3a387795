"""Contouring controller K(θ) of the x and y axes, scheduled by the path's direction.

    x⁺ = A x + B (r - u_c),   v_m = C x + D (r - u_c)
    K(θ) = K_0 + Σ_k (C_k cos kθ + S_k sin kθ),   k = 1 ... 4,   K = [A B; C D]

It weighs the errors along and across the path and therefore knows θ, but not as an
angle: cos kθ and sin kθ follow from the tangent (cos θ, sin θ), so nothing wraps.
With no tangent connected it keeps θ = 0.
Source: Hanifzadegan 2014, sec. 8.2 and 8.4, eq. 8.13 to 8.16, Table 8.3; the design is
that of ``controllers.synthesis.contouring_lpv.planar``.
"""

import json
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers._scheduled import period, system
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_planar.json")
ORDER = 4
SERIES = system(json.loads(DESIGN))
STATES = SERIES.shape[1] - 2


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        STATES
    )


class Input(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")] = 0.0
    r_y: Annotated[float, Var("m", "command, y")] = 0.0
    t_x: Annotated[float, Var("1", "tangent of the path, x")] = 1.0
    t_y: Annotated[float, Var("1", "tangent of the path, y")] = 0.0
    u_cx: Annotated[float, Var("m", "table position, x")] = 0.0
    u_cy: Annotated[float, Var("m", "table position, y")] = 0.0


class Output(NamedTuple):
    v_mx: Annotated[float, Var("V", "command to x")]
    v_my: Annotated[float, Var("V", "command to y")]


class Parameters(NamedTuple):
    K: Annotated[FloatArray, Var("1", "K_0, C_1, S_1, C_2 ... S_4", fixed=True)] = (
        SERIES
    )


def at(t_x: Any, t_y: Any, p: Parameters) -> Any:
    """Return [A B; C D] for a path along the tangent (t_x, t_y)."""
    height = STATES + 2
    K = p.K[:height, :]
    c, s = t_x, t_y
    for k in range(ORDER):
        first = (2 * k + 1) * height
        K = K + c * p.K[first : first + height, :]
        K = K + s * p.K[first + height : first + 2 * height, :]
        c, s = c * t_x - s * t_y, s * t_x + c * t_y
    return K


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the commands of this sample."""
    K = at(u.t_x, u.t_y, p)
    e_x, e_y = u.r_x - u.u_cx, u.r_y - u.u_cy
    z = K[:, :STATES] @ x.x + K[:, STATES] * e_x + K[:, STATES + 1] * e_y
    return State(z[:STATES]), Output(z[STATES], z[STATES + 1])


model = Sampled(
    "KPlanar",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    period_fixed=True,
)
