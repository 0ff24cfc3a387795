"""Errors along and across a path in space.

    e = r - u_c,   e_t = t·e,   e_nb = (I - t t') e

The projection has rank two: its third component follows from the others.  ‖e_nb‖
estimates the contour error.
Source: Hanifzadegan 2014, eq. 8.7 to 8.12; (8.11) is an upper bound, no equality.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var

TINY = 1e-37  # m²; a number in float as well


class State(NamedTuple):
    """The frame remembers nothing."""


class Input(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")] = 0.0
    r_y: Annotated[float, Var("m", "command, y")] = 0.0
    r_z: Annotated[float, Var("m", "command, z")] = 0.0
    t_x: Annotated[float, Var("1", "tangent of the path, x")] = 0.0
    t_y: Annotated[float, Var("1", "tangent of the path, y")] = 0.0
    t_z: Annotated[float, Var("1", "tangent of the path, z")] = 1.0
    u_cx: Annotated[float, Var("m", "position, x")] = 0.0
    u_cy: Annotated[float, Var("m", "position, y")] = 0.0
    u_cz: Annotated[float, Var("m", "position, z")] = 0.0


class Output(NamedTuple):
    e_x: Annotated[float, Var("m", "error, x")]
    e_y: Annotated[float, Var("m", "error, y")]
    e_z: Annotated[float, Var("m", "error, z")]
    e_t: Annotated[float, Var("m", "error along the path")]
    e_nbx: Annotated[float, Var("m", "error across the path, x")]
    e_nby: Annotated[float, Var("m", "error across the path, y")]
    e_nbz: Annotated[float, Var("m", "error across the path, z")]
    e_nb: Annotated[float, Var("m", "size of the error across the path")]


class Parameters(NamedTuple):
    """Nothing to set."""


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the errors of this sample."""
    e_x, e_y, e_z = u.r_x - u.u_cx, u.r_y - u.u_cy, u.r_z - u.u_cz
    e_t = u.t_x * e_x + u.t_y * e_y + u.t_z * e_z
    across = e_x - e_t * u.t_x, e_y - e_t * u.t_y, e_z - e_t * u.t_z
    square: Any = sum(part * part for part in across)
    # a root whose slope is finite on the path, where it is 0
    size: Any = np.where(square > 0, np.sqrt(np.maximum(square, TINY)), 0.0)
    return State(), Output(e_x, e_y, e_z, e_t, *across, size)


model = Sampled(
    "TaskFrameInSpace", step, State(), Input(), Parameters(), period=Fraction(1, 4000)
)
