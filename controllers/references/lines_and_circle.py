"""Path of two lines and the circle that both touch, each from rest to rest.

    line    (x_r, y_r) = (x_0 + s, y_0),                        s to l_1
    circle  (x_r, y_r) = (x_c + R sin φ, y_c - R cos φ),        φ = s/R, s to πDn
    line    onward from there in the direction (cos 2πn, sin 2πn),      s to l_2

with x_c = x_0 + l_1, y_c = y_0 + R.  At rest where the curvature jumps, the axes keep
finite jerk.  The defaults travel 0.38 and 0.29 m.
Source: Hanifzadegan 2014, sec. 7.1.2, fig. 7.3 and 7.4 (diameter, travel and speed;
start, lengths and the other limits are our choice, the path is not tabulated).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.references import trajectory
from controllers.references._path import Input, Output, State, along, move
from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class Parameters(NamedTuple):
    x_0: Annotated[float, Var("m", "start, x axis")] = 0.057
    y_0: Annotated[float, Var("m", "start, y axis")] = 0.110
    l_1: Annotated[float, Var("m", "length of the first line", min=1e-12)] = 0.240
    diameter: Annotated[float, Var("m", "diameter", min=1e-12)] = 0.280
    turns: Annotated[float, Var("1", "turns n, to the left", min=1e-12)] = 1.25
    l_2: Annotated[float, Var("m", "length of the second line", min=1e-12)] = 0.150
    v_max: Annotated[float, Var("m/s", "velocity on the path", min=1e-12)] = 0.4
    a_max: Annotated[float, Var("m/s2", "its tangential rate", min=1e-12)] = 1.0
    j_max: Annotated[float, Var("m/s3", "tangential jerk", min=1e-12)] = 20.0
    s_max: Annotated[float, Var("m/s4", "tangential snap", min=1e-12)] = 1000.0
    t_0: Annotated[float, Var("s", "rest before the first move", min=0)] = 0.1
    dwell: Annotated[float, Var("s", "rest between the moves", min=0)] = 0.1


class Derived(NamedTuple):
    """The moves, and the ticks at which they begin."""

    first: trajectory.Derived
    circle: trajectory.Derived
    second: trajectory.Derived
    k_1: Any
    k_2: Any
    k_3: Any


def lengths(p: Parameters) -> tuple[Any, Any, Any]:
    """Return the lengths of the three pieces (m)."""
    return p.l_1, np.pi * p.diameter * p.turns, p.l_2


def prepare(p: Parameters, T_s: float) -> Derived:
    """Lay out the three moves one after the other."""
    moves = [move(length, p) for length in lengths(p)]
    first, circle, second = (trajectory.prepare(each, T_s) for each in moves)
    T_1, T_2, _ = (sum(T.hi for T in trajectory.stage_times(each)) for each in moves)
    k_1 = tick_of(p.t_0, T_s)
    k_2 = k_1 + tick_of(T_1 + p.dwell, T_s)
    k_3 = k_2 + tick_of(T_2 + p.dwell, T_s)
    return Derived(first, circle, second, k_1, k_2, k_3)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    l_1, around, l_2 = lengths(p)
    line = along(x.k - d.k_1, l_1, p, T_s, d.first)
    turn = along(x.k - d.k_2, around, p, T_s, d.circle)
    onward = along(x.k - d.k_3, l_2, p, T_s, d.second)
    R = p.diameter / 2
    phi, omega = turn.s / R, turn.v / R
    c, s = np.cos(phi), np.sin(phi)
    c_2, s_2 = np.cos(2 * np.pi * p.turns), np.sin(2 * np.pi * p.turns)
    command = Output(
        p.x_0 + line.s + R * s + c_2 * onward.s,
        line.v + c * turn.v + c_2 * onward.v,
        line.a + c * turn.a - s * omega * turn.v + c_2 * onward.a,
        p.y_0 + R * (1 - c) + s_2 * onward.s,
        s * turn.v + s_2 * onward.v,
        s * turn.a + c * omega * turn.v + s_2 * onward.a,
    )
    return State(x.k + 1), command


model = Sampled(
    "LinesAndCirclePath",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(9, 25_000),
    prepare=prepare,
)
