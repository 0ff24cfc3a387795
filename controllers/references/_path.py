"""Motion along a path: the command both axes of a gantry follow.

Along the path the move is that of ``controllers.references.trajectory``, in metres:
velocity, acceleration, jerk and snap limited.  S = 4 J²/A makes the ramps of a
jerk pulse a fifth of it, as in the study.
"""

from typing import Annotated, Any, NamedTuple

from controllers.references import trajectory
from fmus.model import Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    x_r: Annotated[float, Var("m", "command of the x axis")]
    v_xr: Annotated[float, Var("m/s", "its velocity")]
    a_xr: Annotated[float, Var("m/s2", "its acceleration")]
    y_r: Annotated[float, Var("m", "command of the y axis")]
    v_yr: Annotated[float, Var("m/s", "its velocity")]
    a_yr: Annotated[float, Var("m/s2", "its acceleration")]


class Along(NamedTuple):
    """Arc length and its derivatives in time."""

    s: Any
    v: Any
    a: Any


def move(length: Any, p: Any) -> trajectory.Parameters:
    """Return the move over a length (m) with the limits of p, from v_max to s_max."""
    return trajectory.Parameters(
        length, p.v_max, p.a_max, p.j_max, p.s_max, t_0=0.0, back=False, r_g=1.0
    )


def along(k: Any, length: Any, p: Any, T_s: Any, d: trajectory.Derived) -> Along:
    """Return where the move is k ticks after it began; p as for ``move``."""
    _, y = trajectory.step(
        trajectory.State(k), trajectory.Input(), move(length, p), T_s, d
    )
    return Along(y.x_r, y.v_r, y.a_r)
