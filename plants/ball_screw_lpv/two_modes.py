"""Rigid body and the first two modes of the screw's wave equations.

    M ü_0 = f + f_c - c_m/r_g² u̇_0,      M = (J_m + ρ_s J_s l_s)/r_g² + m_tab + m_wor
    q̈_k = -ω_k² q_k - 2ζ_k ω_k q̇_k + φ_mk f + φ_ck f_c,       k = 1, 2
    u_m = u_0 + Σ φ_mk q_k,      u_c = u_0 + Σ φ_ck q_k

with modal masses of 1 kg.  ω and φ follow nut distance and workpiece mass by a table
of exact solutions of (A.1) to (A.11) with the parameters of ``hybrid``; ζ_1 is its
structural damping at 0.59 m, ζ_2 the same, as nothing is published.  f is the motor
force less friction.
Source: Hanifzadegan 2014, eq. 3.20 with two modes, appendix A.1 and A.2.
"""

import json
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.data import read_data
from fmus.model import Continuous, FloatArray, Var
from fmus.table import lookup_rows, slopes
from plants.ball_screw_lpv._drive import Amplifier, Friction, motor_force
from plants.ball_screw_lpv._mode import R_G
from plants.ball_screw_lpv._ports import Input, Output

TABLE = json.loads(read_data(__file__, "two_modes.json"))


class State(NamedTuple):
    u_0: Annotated[float, Var("m", "position of the rigid body", nominal=0.01)] = 0.0
    v: Annotated[float, Var("m/s", "speed of the rigid body", nominal=0.1)] = 0.0
    q: Annotated[FloatArray, Var("m", "deflections of the modes", nominal=1e-4)] = (
        np.zeros(2)
    )
    q_1: Annotated[FloatArray, Var("m/s", "their rates", nominal=0.1)] = np.zeros(2)


class Waves(NamedTuple):
    """Both modes at nut distances and, for each, at masses of the workpiece."""

    x_c: Annotated[
        FloatArray, Var("m", "nut distances of the table", fixed=True, min=0)
    ] = np.array(TABLE["x_c"])
    m_wor: Annotated[
        FloatArray, Var("kg", "masses of the table", fixed=True, min=0)
    ] = np.array(TABLE["m_wor"])
    modes: Annotated[
        FloatArray, Var("1", "ω in rad/s, φ_m, φ_c of both modes", fixed=True)
    ] = np.array(TABLE["modes"]).reshape(-1, 6)


class Parameters(NamedTuple):
    waves: Waves = Waves()
    zeta: Annotated[FloatArray, Var("1", "damping ratios", min=0)] = np.array(
        [0.0199, 0.0199]
    )
    M: Annotated[float, Var("kg", "mass of the rigid body, no workpiece")] = 70.42258
    c_m: Annotated[float, Var("N.m.s/rad", "viscous damping of the motor", min=0)] = (
        0.0156
    )
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = R_G
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction()
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


class Derived(NamedTuple):
    modes: FloatArray


def prepare(p: Parameters) -> Derived:
    """Return the slopes of the table over the nut distance."""
    return Derived(slopes(p.waves.x_c, p.waves.modes))


def modes_at(u: Input, p: Parameters, d: Derived) -> Any:
    """Return ω, φ_m, φ_c of both modes, (2, 3)."""
    here = lookup_rows(u.x_c, p.waves.x_c, p.waves.modes, d.modes)
    row = lookup_rows(u.m_wor, p.waves.m_wor, here)
    return np.concatenate([row[:, 0:3], row[:, 3:6]])


def derivative(x: State, u: Input, p: Parameters, d: Derived) -> State:
    """Return ẋ."""
    f = motor_force(u.v_m, u.f_m, x.v, p.amplifier, p.friction, p.r_g)
    modes = modes_at(u, p, d)
    omega, phi_m, phi_c = modes[:, 0], modes[:, 1], modes[:, 2]
    a = (f + u.f_c - p.c_m / (p.r_g * p.r_g) * x.v) / (p.M + u.m_wor)
    spring = omega * omega * x.q + 2 * p.zeta * omega * x.q_1
    return State(x.v, a, x.q_1, phi_m * f + phi_c * u.f_c - spring)


def output(x: State, u: Input, p: Parameters, d: Derived) -> Output:
    """Return what the modes add to the rigid body at either end."""
    modes = modes_at(u, p, d)
    u_m = x.u_0 + np.dot(modes[:, 1], x.q)
    u_c = x.u_0 + np.dot(modes[:, 2], x.q)
    return Output(u_m, u_c, p.x_0 - u_c, x.v)


model = Continuous(
    "TwoModeBallScrew",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=3e-5,
    prepare=prepare,
)
