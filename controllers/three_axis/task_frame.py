"""Errors in the frame of the path: along it, across it, and across it delayed.

    (e_t, e_n) = T (r - u_c),   T = [t_x t_y; -t_y t_x],   t_d = e_t/|ṙ|
    e_nd = -t_y(t - t_d) (r_x(t - t_d) - u_cx) + t_x(t - t_d) (r_y(t - t_d) - u_cy)

e_nd is the better estimate of the contour error.  The command of the past 127 samples
is remembered, linear between samples: t_d stays within them and is not negative.
Below ``v_min`` it is 0.  The frame comes from the tangent, no angle is taken.
Source: Hanifzadegan 2014, eq. 8.3 to 8.6; (8.5) is printed as no rotation.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import FloatArray, Sampled, Var

DEPTH = 128


class State(NamedTuple):
    k: Annotated[float, Var("1", "samples remembered")] = 0.0
    r_x: Annotated[FloatArray, Var("m", "past commands, x")] = np.zeros(DEPTH - 1)
    r_y: Annotated[FloatArray, Var("m", "past commands, y")] = np.zeros(DEPTH - 1)
    t_x: Annotated[FloatArray, Var("1", "past tangents, x")] = np.zeros(DEPTH - 1)
    t_y: Annotated[FloatArray, Var("1", "past tangents, y")] = np.zeros(DEPTH - 1)


class Input(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")] = 0.0
    r_y: Annotated[float, Var("m", "command, y")] = 0.0
    v_rx: Annotated[float, Var("m/s", "its velocity, x")] = 0.0
    v_ry: Annotated[float, Var("m/s", "its velocity, y")] = 0.0
    t_x: Annotated[float, Var("1", "tangent of the path, x")] = 1.0
    t_y: Annotated[float, Var("1", "tangent of the path, y")] = 0.0
    u_cx: Annotated[float, Var("m", "table position, x")] = 0.0
    u_cy: Annotated[float, Var("m", "table position, y")] = 0.0


class Output(NamedTuple):
    e_x: Annotated[float, Var("m", "error, x")]
    e_y: Annotated[float, Var("m", "error, y")]
    e_t: Annotated[float, Var("m", "error along the path")]
    e_n: Annotated[float, Var("m", "error across the path")]
    t_d: Annotated[float, Var("s", "delay behind the command")]
    e_nd: Annotated[float, Var("m", "contour error, estimated with the delay")]


class Parameters(NamedTuple):
    v_min: Annotated[float, Var("m/s", "slowest with a delay", min=1e-9)] = 0.03


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the errors of this sample."""
    e_x, e_y = u.r_x - u.u_cx, u.r_y - u.u_cy
    e_t, e_n = u.t_x * e_x + u.t_y * e_y, u.t_x * e_y - u.t_y * e_x
    speed = np.sqrt(u.v_rx * u.v_rx + u.v_ry * u.v_ry)
    slow = speed < p.v_min
    late = np.where(slow, 0.0, e_t / np.maximum(speed, p.v_min))
    t_d: Any = np.minimum(np.maximum(late, 0.0), x.k * T_s)

    past = [np.concatenate([now, kept]) for now, kept in _pairs(u, x)]
    share = np.maximum(1.0 - np.abs(t_d / T_s - np.arange(DEPTH)), 0.0)
    r_x, r_y, t_x, t_y = (np.dot(share, kept) for kept in past)
    size = np.sqrt(np.maximum(t_x * t_x + t_y * t_y, 1e-18))
    e_nd = (t_x * (r_y - u.u_cy) - t_y * (r_x - u.u_cx)) / size
    kept = (row[: DEPTH - 1] for row in past)
    k = np.minimum(x.k + 1, DEPTH - 1)
    return State(k, *kept), Output(e_x, e_y, e_t, e_n, t_d, e_nd)


def _pairs(u: Input, x: State) -> list[tuple[Any, Any]]:
    one = np.ones(1)
    return [
        (one * u.r_x, x.r_x),
        (one * u.r_y, x.r_y),
        (one * u.t_x, x.t_x),
        (one * u.t_y, x.t_y),
    ]


model = Sampled(
    "TaskFrame", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
