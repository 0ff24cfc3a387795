"""Motion of a rigid body with one flexible mode, in its minimal form.

Source: Hanifzadegan 2014, eq. 3.28 to 3.35 without the redundant states.
"""

from typing import Annotated, Any, NamedTuple

from fmus.model import Var
from plants.ball_screw_lpv._drive import Amplifier, Friction, motor_force
from plants.ball_screw_lpv._mode import Mode, Rigid, force_on_table
from plants.ball_screw_lpv._ports import Input, Output


class State(NamedTuple):
    u_0: Annotated[float, Var("m", "position of the rigid body", nominal=0.01)] = 0.0
    v: Annotated[float, Var("m/s", "speed of the rigid body", nominal=0.1)] = 0.0
    q: Annotated[float, Var("N.s2", "deflection of the mode", nominal=1e-4)] = 0.0
    q_1: Annotated[float, Var("N.s", "its rate", nominal=0.1)] = 0.0


def motion(
    x: State,
    u: Input,
    mode: Mode,
    J_e: Any,
    rigid: Rigid,
    amplifier: Amplifier,
    friction: Friction,
) -> State:
    """Return ẋ with the inertia J_e (kg m²)."""
    f = motor_force(u.v_m, u.f_m, x.v, amplifier, friction, rigid.r_g)
    return rates(x, f, u.f_c, mode, J_e, rigid)


def rates(x: State, f: Any, f_c: Any, mode: Mode, J_e: Any, rigid: Rigid) -> State:
    """Return ẋ under forces on the motor side, f, and on the table, f_c (N)."""
    b_0, b_1 = force_on_table(mode)
    a = (rigid.r_g * rigid.r_g * (f + f_c) - rigid.B_e * x.v) / J_e
    spring = mode.omega * mode.omega * x.q + 2 * mode.zeta * mode.omega * x.q_1
    return State(x.v, a, x.q_1 + b_0 * f_c, f + b_1 * f_c - spring)


def positions(x: State, mode: Mode, x_0: Any) -> Output:
    """Return what the mode adds to the rigid body at either end."""
    u_m = x.u_0 + mode.alpha_11 * x.q + mode.beta_11 * x.q_1
    u_c = x.u_0 + mode.alpha_12 * x.q + mode.beta_12 * x.q_1
    return Output(u_m, u_c, x_0 - u_c, x.v)
