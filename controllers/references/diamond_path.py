"""Diamond: a square on its corner about (x_0, y_0), with a full stop in each corner.

Begun in the corner of positive x, run towards positive y; each of the four sides
is one jerk-limited move and begins on a tick.
Source: Gordon 2010, sec. 4.5 (sides of 1 μm, 1 mm and 200 mm); the stops in the
corners are our reading.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.references import trajectory
from controllers.references._path import Input, Output, State, along, move
from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class Parameters(NamedTuple):
    x_0: Annotated[float, Var("m", "centre, x axis")] = 0.0
    y_0: Annotated[float, Var("m", "centre, y axis")] = 0.0
    side: Annotated[float, Var("m", "length of a side", min=1e-12)] = 0.2
    v_max: Annotated[float, Var("m/s", "velocity on the path", min=1e-12)] = 0.2
    a_max: Annotated[float, Var("m/s2", "acceleration", min=1e-12)] = 2.0
    j_max: Annotated[float, Var("m/s3", "jerk", min=1e-12)] = 50.0
    s_max: Annotated[float, Var("m/s4", "snap", min=1e-12)] = 5000.0
    t_0: Annotated[float, Var("s", "rest before the move", min=0)] = 0.0
    dwell: Annotated[float, Var("s", "rest in each corner", min=0)] = 0.0


class Derived(NamedTuple):
    side: trajectory.Derived
    ticks: Any  # from corner to corner


def prepare(p: Parameters, T_s: float) -> Derived:
    """Lay out the move along one side."""
    side = move(p.side, p)
    duration = sum(T.hi for T in trajectory.stage_times(side))
    return Derived(trajectory.prepare(side, T_s), tick_of(duration + p.dwell, T_s))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    k = x.k - tick_of(p.t_0, T_s)
    n = np.minimum(np.maximum(np.floor(k / d.ticks), 0.0), 3.0)
    now = along(k - n * d.ticks, p.side, p, T_s, d.side)
    h = np.sqrt(0.5)
    # side n leaves corner n: right, top, left, bottom
    corner_x = which(n, 1.0, 0.0, -1.0, 0.0) * (h * p.side)
    corner_y = which(n, 0.0, 1.0, 0.0, -1.0) * (h * p.side)
    c_x = which(n, -h, -h, h, h)
    c_y = which(n, h, -h, -h, h)
    command = Output(
        p.x_0 + (corner_x + c_x * now.s),
        c_x * now.v,
        c_x * now.a,
        p.y_0 + (corner_y + c_y * now.s),
        c_y * now.v,
        c_y * now.a,
    )
    return State(x.k + 1), command


def which(n: Any, *values: float) -> Any:
    """Return the value of side n, 0 to 3."""
    chosen: Any = values[-1]
    for i in (2, 1, 0):
        chosen = np.where(n < i + 0.5, values[i], chosen)
    return chosen


model = Sampled(
    "DiamondPath",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
