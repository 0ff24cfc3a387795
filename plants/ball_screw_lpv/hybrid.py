"""Hybrid analytic model: motor and table joined by a screw with its own mass.

    M(x_c, m_wor) ü + C u̇ + k̂_e(x_c) [1 -1; -1 1] u = (f, f_c)
    C = diag(c_m/r_g², c_c) + c_hys [1 -1; -1 1],     u = (u_m, u_c)

with structural damping c_hys(x_c, m_wor); f is the motor force less friction, which
acts on the motor's speed.  ``x_n`` = x_0 - u_c.
Source: Hanifzadegan 2014, eq. 3.9 to 3.16 and appendix A.3.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv._drive import Amplifier, Friction, motor_force
from plants.ball_screw_lpv._ports import Input, Output
from plants.ball_screw_lpv._screw import Screw, matrices


class State(NamedTuple):
    u_m: Annotated[float, Var("m", "motor position", nominal=0.01)] = 0.0
    u_c: Annotated[float, Var("m", "table position", nominal=0.01)] = 0.0
    v_m: Annotated[float, Var("m/s", "motor speed as table speed", nominal=0.1)] = 0.0
    v_c: Annotated[float, Var("m/s", "table speed", nominal=0.1)] = 0.0


class Parameters(NamedTuple):
    screw: Screw = Screw()
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction()
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ (eq. 3.9)."""
    r_g = p.screw.r_g
    f = motor_force(u.v_m, u.f_m, x.v_m, p.amplifier, p.friction, r_g)
    return motion(x, f, u, p.screw)


def motion(x: State, f: float, u: Input, screw: Screw) -> State:
    """Return ẋ under a motor force f (N)."""
    m = matrices(u.x_c, u.m_wor, screw)
    nut = m.k_e * (x.u_c - x.u_m) + m.c_hys * (x.v_c - x.v_m)
    f_1 = f + nut - screw.c_m / (screw.r_g * screw.r_g) * x.v_m
    f_2 = u.f_c - nut - screw.c_c * x.v_c
    determinant = m.m_11 * m.m_22 - m.m_12 * m.m_12
    a_m = (m.m_22 * f_1 - m.m_12 * f_2) / determinant
    a_c = (m.m_11 * f_2 - m.m_12 * f_1) / determinant
    return State(x.v_m, x.v_c, a_m, a_c)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions."""
    return Output(x.u_m, x.u_c, p.x_0 - x.u_c, x.v_m)


model = Continuous(
    "HybridBallScrew", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
