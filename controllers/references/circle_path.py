"""Circle about (x_0, y_0), begun at the side of positive x, jerk limited.

    x_r = x_0 + R cos φ,   y_r = y_0 + R sin φ,   φ = s(t)/R

with s from rest to rest over n turns; derivatives by the chain rule.  A circle at
full speed from the first instant: ``controllers.references.circle``.
Source: Gordon 2010, sec. 4.5 (diameters of 1 μm, 1 mm and 200 mm).
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
    diameter: Annotated[float, Var("m", "diameter", min=1e-12)] = 0.2
    turns: Annotated[float, Var("1", "turns, clockwise if negative")] = 1.0
    v_max: Annotated[float, Var("m/s", "velocity on the path", min=1e-12)] = 0.2
    a_max: Annotated[float, Var("m/s2", "its tangential rate", min=1e-12)] = 2.0
    j_max: Annotated[float, Var("m/s3", "tangential jerk", min=1e-12)] = 50.0
    s_max: Annotated[float, Var("m/s4", "tangential snap", min=1e-12)] = 5000.0
    t_0: Annotated[float, Var("s", "rest before the move", min=0)] = 0.0


def length(p: Parameters) -> Any:
    """Return the arc length of all turns (m), signed."""
    return np.pi * p.diameter * p.turns


def prepare(p: Parameters, T_s: float) -> trajectory.Derived:
    """Lay out the move along the circle."""
    return trajectory.prepare(move(length(p), p), T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: trajectory.Derived
) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    now = along(x.k - tick_of(p.t_0, T_s), length(p), p, T_s, d)
    R = p.diameter / 2
    phi, omega = now.s / R, now.v / R
    c, s = np.cos(phi), np.sin(phi)
    command = Output(
        p.x_0 + R * c,
        -s * now.v,
        -s * now.a - c * omega * now.v,
        p.y_0 + R * s,
        c * now.v,
        c * now.a - s * omega * now.v,
    )
    return State(x.k + 1), command


model = Sampled(
    "CirclePath",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
