"""Gridded LQG of three axes along a path in space, scheduled by its progress.

    y = r - u_c,    v_m = -K(q) (x̂, w)
    x̂⁺ = F x̂ + G v_m + L (y - C x̂),    w⁺ = A_w w + B_w T y
    T y = (e_t, e_nbx, e_nby),   T = [t'; the first two rows of I - t t']

x̂ are the plant's slow modes as the error shows them, w the weights' states.  K is
linear between the points of its grid over q; L is one for all.  It belongs to the
path that it was designed along and nothing certifies it.
Source: Hanifzadegan 2014, sec. 8.5, eq. 8.7 to 8.12, Table 8.4 for the weights; gridded
LQG is ours (``controllers.synthesis.contouring_lpv.lqg``).
"""

import json
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers._scheduled import period
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var
from fmus.table import lookup_rows, slopes

DESIGN = read_data(__file__, "lqg_spatial.json")
_NUMBERS = {name: np.array(value) for name, value in json.loads(DESIGN).items()}
AXES = 3


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "slow modes of the plant", nominal=1e-4)] = (
        np.zeros(len(_NUMBERS["F"]))
    )
    w: Annotated[FloatArray, Var("1", "states of the weights", nominal=1e-4)] = (
        np.zeros(len(_NUMBERS["A_w"]))
    )


class Input(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")] = 0.0
    r_y: Annotated[float, Var("m", "command, y")] = 0.0
    r_z: Annotated[float, Var("m", "command, z")] = 0.0
    t_x: Annotated[float, Var("1", "tangent of the path, x")] = 0.0
    t_y: Annotated[float, Var("1", "tangent of the path, y")] = 0.0
    t_z: Annotated[float, Var("1", "tangent of the path, z")] = 1.0
    q: Annotated[float, Var("1", "share of the path that is done")] = 0.0
    u_cx: Annotated[float, Var("m", "position, x")] = 0.0
    u_cy: Annotated[float, Var("m", "position, y")] = 0.0
    u_cz: Annotated[float, Var("m", "position, z")] = 0.0


class Output(NamedTuple):
    v_mx: Annotated[float, Var("V", "command to x")]
    v_my: Annotated[float, Var("V", "command to y")]
    v_mz: Annotated[float, Var("V", "command to z")]


class Parameters(NamedTuple):
    F: Annotated[FloatArray, Var("1", "slow modes over a sample", constant=True)] = (
        _NUMBERS["F"]
    )
    G: Annotated[FloatArray, Var("1", "how v_m drives them", constant=True)] = _NUMBERS[
        "G"
    ]
    C: Annotated[FloatArray, Var("1", "what they do to y", constant=True)] = _NUMBERS[
        "C"
    ]
    L: Annotated[FloatArray, Var("1", "gain of the filter", constant=True)] = _NUMBERS[
        "L"
    ]
    A_w: Annotated[FloatArray, Var("1", "weights over a sample", constant=True)] = (
        _NUMBERS["A_w"]
    )
    B_w: Annotated[FloatArray, Var("1", "how T y drives them", constant=True)] = (
        _NUMBERS["B_w"]
    )
    grid: Annotated[FloatArray, Var("1", "points over q", constant=True)] = _NUMBERS[
        "q"
    ]
    K: Annotated[FloatArray, Var("1", "K at each point of it", constant=True)] = (
        _NUMBERS["K"]
    )


class Derived(NamedTuple):
    K: Any


def prepare(p: Parameters, T_s: float) -> Derived:
    """Return the slopes of K over q."""
    return Derived(slopes(p.grid, p.K))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the commands of this sample."""
    K = lookup_rows(u.q, p.grid, p.K, d.K)
    n = p.F.shape[0]
    v = -(K[:, :n] @ x.x + K[:, n:] @ x.w)
    y = u.r_x - u.u_cx, u.r_y - u.u_cy, u.r_z - u.u_cz
    e_t = u.t_x * y[0] + u.t_y * y[1] + u.t_z * y[2]
    task = e_t, y[0] - e_t * u.t_x, y[1] - e_t * u.t_y

    foreseen = p.C @ x.x
    x_next, w_next = p.F @ x.x + p.G @ v, p.A_w @ x.w
    for i in range(AXES):
        x_next = x_next + p.L[:, i] * (y[i] - foreseen[i])
        w_next = w_next + p.B_w[:, i] * task[i]
    return State(x_next, w_next), Output(v[0], v[1], v[2])


model = Sampled(
    "LQGSpatial",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=prepare,
    period_fixed=True,
)
