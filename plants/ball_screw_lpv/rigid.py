"""Rigid body with Coulomb friction: the drive at low frequencies.

    J_e(m_wor) θ̈ = r_g (f + f_c) - B_e θ̇,     u_m = u_c = r_g θ

f is the motor force less friction (eq. 3.22, repaired: printed T_f/r_g stands for
T_f r_g/r_g, and θ̇ for the table's speed).
Source: Hanifzadegan 2014, eq. 3.2 to 3.4, 3.21 to 3.23, Table 3.2.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv._drive import Amplifier, Friction, motor_force
from plants.ball_screw_lpv._mode import Rigid, inertia
from plants.ball_screw_lpv._ports import Input, Output


class State(NamedTuple):
    theta: Annotated[float, Var("rad", "screw angle")] = 0.0
    omega: Annotated[float, Var("rad/s", "screw speed")] = 0.0


class Parameters(NamedTuple):
    rigid: Rigid = Rigid()
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction()
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    r_g = p.rigid.r_g
    f = motor_force(u.v_m, u.f_m, r_g * x.omega, p.amplifier, p.friction, r_g)
    torque = r_g * (f + u.f_c) - p.rigid.B_e * x.omega
    return State(x.omega, torque / inertia(u.m_wor, p.rigid))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the position at either end, and the nut distance."""
    position = p.rigid.r_g * x.theta
    return Output(position, position, p.x_0 - position, p.rigid.r_g * x.omega)


model = Continuous(
    "RigidBallScrew", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
