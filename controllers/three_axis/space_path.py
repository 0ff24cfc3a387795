"""Path in space whose tangent leans away from z and turns about it.

    t = (sin α cos ψ, sin α sin ψ, cos α),   α = α_0 (1 - cos 2πq),   ψ = 4π q
    r(q) = L ∫ t dq

The integral goes from tick to tick by three points of Gauss: its error is far below
that of a sum.  ``_ramp`` runs q.  With α_0 = 20° the path stays within α_z < 45°.
Source: Hanifzadegan 2014, sec. 8.5.3 and fig. 8.16, which print no path: this one is
our choice, within 1.5 rad/s of turning.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.three_axis._ramp import progress
from fmus.model import Sampled, Var

POINTS = (0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15))
WEIGHTS = (5 / 18, 8 / 18, 5 / 18)


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0
    r_x: Annotated[float, Var("m", "where the path is, x", nominal=0.01)] = 0.0
    r_y: Annotated[float, Var("m", "where the path is, y", nominal=0.01)] = 0.0
    r_z: Annotated[float, Var("m", "where the path is, z", nominal=0.01)] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")]
    r_y: Annotated[float, Var("m", "command, y")]
    r_z: Annotated[float, Var("m", "command, z")]
    t_x: Annotated[float, Var("1", "tangent of the path, x")]
    t_y: Annotated[float, Var("1", "tangent of the path, y")]
    t_z: Annotated[float, Var("1", "tangent of the path, z")]
    q: Annotated[float, Var("1", "share of the path that is done")]


class Parameters(NamedTuple):
    L: Annotated[float, Var("m", "length of the path", min=1e-9)] = 0.5
    alpha_0: Annotated[float, Var("rad", "half the largest lean")] = np.pi / 9
    T: Annotated[float, Var("s", "time of the path", min=1e-6)] = 10.0
    t_r: Annotated[float, Var("s", "time of a ramp, at most T/2", min=0)] = 0.5


def tangent(q: Any, alpha_0: Any) -> tuple[Any, Any, Any]:
    """Return the unit tangent where a share q of the path is done."""
    alpha, psi = alpha_0 * (1 - np.cos(2 * np.pi * q)), 4 * np.pi * q
    s = np.sin(alpha)
    return s * np.cos(psi), s * np.sin(psi), np.cos(alpha)


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command at t = k T_s."""
    q = progress(x.k * T_s, p.T, p.t_r).q
    further = progress((x.k + 1) * T_s, p.T, p.t_r).q - q
    r_x, r_y, r_z = x.r_x, x.r_y, x.r_z
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        t_x, t_y, t_z = tangent(q + point * further, p.alpha_0)
        part = weight * p.L * further
        r_x, r_y, r_z = r_x + part * t_x, r_y + part * t_y, r_z + part * t_z
    command = Output(x.r_x, x.r_y, x.r_z, *tangent(q, p.alpha_0), q)
    return State(x.k + 1, r_x, r_y, r_z), command


model = Sampled(
    "SpacePath", step, State(), Input(), Parameters(), period=Fraction(1, 4000)
)
