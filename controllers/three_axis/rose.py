"""Rose of four petals about the origin, begun at the tip (R, 0).

    r_x = R cos 2p cos p,   r_y = R cos 2p sin p,   p = 2π q(t)

``_ramp`` runs q.  The tangent is that of the path, also where it rests; its angle
turns by 6π in all, at ṗ (1 + 4/(1 + 3 sin² 2p)).
Source: Hanifzadegan 2014, sec. 8.4.2 and fig. 8.10, which print neither size nor time
law: R, T and t_r are our choice, within 11 rad/s of turning.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.three_axis._ramp import progress
from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")]
    r_y: Annotated[float, Var("m", "command, y")]
    v_rx: Annotated[float, Var("m/s", "its velocity, x")]
    v_ry: Annotated[float, Var("m/s", "its velocity, y")]
    t_x: Annotated[float, Var("1", "tangent of the path, x")]
    t_y: Annotated[float, Var("1", "tangent of the path, y")]


class Parameters(NamedTuple):
    R: Annotated[float, Var("m", "length of a petal", min=1e-9)] = 0.05
    T: Annotated[float, Var("s", "time of the path", min=1e-6)] = 5.0
    t_r: Annotated[float, Var("s", "time of a ramp, at most T/2", min=0)] = 0.5
    t_0: Annotated[float, Var("s", "rest before the path", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    now = progress(x.k * T_s - p.t_0, p.T, p.t_r)
    angle = 2 * np.pi * now.q
    c, s, c_2 = np.cos(angle), np.sin(angle), np.cos(2 * angle)
    along, across = -2 * np.sin(2 * angle), c_2
    size = np.sqrt(along * along + across * across)
    t_x, t_y = (along * c - across * s) / size, (along * s + across * c) / size
    v = p.R * size * 2 * np.pi * now.rate
    command = Output(p.R * c_2 * c, p.R * c_2 * s, v * t_x, v * t_y, t_x, t_y)
    return State(x.k + 1), command


model = Sampled(
    "RosePath", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
