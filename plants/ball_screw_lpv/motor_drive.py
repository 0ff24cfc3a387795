"""Motor with current loop on the rigid drive: G_1 and G_0 in one plant.

    J_e θ̈ = k_t i - T_f - B_e θ̇ + r_g f

The winding of ``current_loop`` feels the back-EMF of the speed it makes; coupled
over FMUs the exchange would lag.  J_e = 5.9e-4 kg m² as from Table 3.1.
Source: Hanifzadegan 2014, eq. 3.2 and 3.6 to 3.8, fig. 3.2 and 3.3.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv import current_loop
from plants.ball_screw_lpv._drive import Friction, friction_torque
from plants.ball_screw_lpv._mode import Rigid


class State(NamedTuple):
    winding: current_loop.State = current_loop.State()
    theta: Annotated[float, Var("rad", "screw angle")] = 0.0
    omega: Annotated[float, Var("rad/s", "screw speed")] = 0.0


class Input(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")] = 0.0
    f: Annotated[float, Var("N", "force on motor or table")] = 0.0


class Output(NamedTuple):
    i: Annotated[float, Var("A", "motor current")]
    tau_m: Annotated[float, Var("N.m", "motor torque")]
    u_m: Annotated[float, Var("m", "motor position as table travel")]
    v: Annotated[float, Var("m/s", "table speed")]


class Parameters(NamedTuple):
    winding: current_loop.Parameters = current_loop.Parameters()
    rigid: Rigid = Rigid(J_e=5.9e-4)
    friction: Friction = Friction(on=False)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    told = current_loop.Input(u.v_m, x.omega)
    winding = current_loop.derivative(x.winding, told, p.winding)
    tau_m = current_loop.output(x.winding, told, p.winding).tau_m
    torque = tau_m - friction_torque(p.rigid.r_g * x.omega, p.friction)
    torque = torque + p.rigid.r_g * u.f - p.rigid.B_e * x.omega
    return State(winding, x.omega, torque / p.rigid.J_e)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return current, torque and motion."""
    told = current_loop.Input(u.v_m, x.omega)
    y = current_loop.output(x.winding, told, p.winding)
    return Output(y.i, y.tau_m, p.rigid.r_g * x.theta, p.rigid.r_g * x.omega)


model = Continuous(
    "MotorDrive", derivative, output, State(), Input(), Parameters(), h_max=2e-5
)
