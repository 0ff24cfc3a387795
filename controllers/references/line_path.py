"""Straight line from (x_0, y_0) over (stroke_x, stroke_y), jerk limited.

    (x_r, y_r) = (x_0, y_0) + s(t) (stroke_x, stroke_y)/l

Source: Gordon 2010, sec. 4.5 (1 and 200 mm/s); the stroke is our choice.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.references import trajectory
from controllers.references._path import Input, Output, State, along, move
from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class Parameters(NamedTuple):
    x_0: Annotated[float, Var("m", "start, x axis")] = 0.0
    y_0: Annotated[float, Var("m", "start, y axis")] = 0.0
    stroke_x: Annotated[float, Var("m", "length along x, signed")] = 0.0
    stroke_y: Annotated[float, Var("m", "length along y, signed")] = 0.2
    v_max: Annotated[float, Var("m/s", "velocity on the path", min=1e-12)] = 0.2
    a_max: Annotated[float, Var("m/s2", "acceleration", min=1e-12)] = 2.0
    j_max: Annotated[float, Var("m/s3", "jerk", min=1e-12)] = 50.0
    s_max: Annotated[float, Var("m/s4", "snap", min=1e-12)] = 5000.0
    t_0: Annotated[float, Var("s", "rest before the move", min=0)] = 0.0


def length(p: Parameters) -> Any:
    """Return the length of the line (m), never zero."""
    square = p.stroke_x * p.stroke_x + p.stroke_y * p.stroke_y
    return np.maximum(np.sqrt(square), 1e-12)


def prepare(p: Parameters, T_s: float) -> trajectory.Derived:
    """Lay out the move along the line."""
    return trajectory.prepare(move(length(p), p), T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: trajectory.Derived
) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    l = length(p)  # noqa: E741
    now = along(x.k - tick_of(p.t_0, T_s), l, p, T_s, d)
    c_x, c_y = p.stroke_x / l, p.stroke_y / l
    command = Output(
        p.x_0 + c_x * now.s,
        c_x * now.v,
        c_x * now.a,
        p.y_0 + c_y * now.s,
        c_y * now.v,
        c_y * now.a,
    )
    return State(x.k + 1), command


model = Sampled(
    "LinePath",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
