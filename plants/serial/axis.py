"""One axis of the serial machine: a ball screw whose mode follows its nut.

    u̇_0 = v,                  v̇ = (r_b² (f + f_c) - B_e v)/J_e
    q̇ = q_1 + b_0 f_c,        q̇_1 = -ω² q - 2ζω q_1 + f + b_1 f_c
    u_m = u_0 + α_11 q + β_11 q_1,      u_c = u_0 + α_12 q + β_12 q_1
    f = (k_t k_a v_m - T_f)/r_g,        x_c = x_0 - u_0

The motor's force has the printed r_g of 0.0032 m/rad, 199.575 N/V; body and mode were
identified with r_b = 0.020 m/2π (Table 3.3, m_wor = 0).  The deflection, some µm, is
left out of x_c.  Coulomb friction is there and off: the source simulates without.
Source: Hanifzadegan 2014, sec. 7.1, eq. 3.20, 3.27, 3.28.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv import _ports
from plants.ball_screw_lpv._drive import Amplifier, Friction, motor_force
from plants.ball_screw_lpv._modal import State, positions, rates
from plants.ball_screw_lpv._mode import Mode, OverPosition, Rigid, over_position


class Input(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")] = 0.0
    f_c: Annotated[float, Var("N", "external force on the table")] = 0.0


class Parameters(NamedTuple):
    r_g: Annotated[
        float, Var("m/rad", "table travel per screw angle, of the motor", min=1e-9)
    ] = 0.0032
    rigid: Rigid = Rigid()
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction(on=False)
    mode: OverPosition = OverPosition()
    run_out: Annotated[bool, Var("1", "the mode varies with the screw angle too")] = (
        False
    )
    x_0: Annotated[float, Var("m", "nut distance at u_0 = 0")] = 0.65


def mode_at(x: State, p: Parameters) -> Mode:
    """Return the mode where the nut is."""
    return over_position(p.x_0 - x.u_0, p.mode, p.rigid.r_g, p.run_out)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    f = motor_force(u.v_m, 0.0, x.v, p.amplifier, p.friction, p.r_g)
    return rates(x, f, u.f_c, mode_at(x, p), p.rigid.J_e, p.rigid)


def output(x: State, u: Input, p: Parameters) -> _ports.Output:
    """Return both positions, the nut distance and the speed."""
    return positions(x, mode_at(x, p), p.x_0)


model = Continuous(
    "SerialAxis", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
