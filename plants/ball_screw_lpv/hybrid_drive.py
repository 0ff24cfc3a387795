"""Whole drive, analytic: current loop, screw, table.

The plant of ``hybrid`` under the torque of ``current_loop``, whose back-EMF is that
of the motor's end; what the design takes for a gain k_a is here the loop itself.
Source: Hanifzadegan 2014, eq. 3.6 to 3.16, fig. 3.2 and 3.4.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv import current_loop, hybrid
from plants.ball_screw_lpv._drive import Friction, friction_torque
from plants.ball_screw_lpv._ports import Input, Output
from plants.ball_screw_lpv._screw import Screw


class State(NamedTuple):
    winding: current_loop.State = current_loop.State()
    screw: hybrid.State = hybrid.State()


class Parameters(NamedTuple):
    winding: current_loop.Parameters = current_loop.Parameters()
    screw: Screw = Screw()
    friction: Friction = Friction()
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    r_g = p.screw.r_g
    told = current_loop.Input(u.v_m, x.screw.v_m / r_g)
    tau_m = current_loop.output(x.winding, told, p.winding).tau_m
    f = (tau_m - friction_torque(x.screw.v_m, p.friction)) / r_g + u.f_m
    winding = current_loop.derivative(x.winding, told, p.winding)
    return State(winding, hybrid.motion(x.screw, f, u, p.screw))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions."""
    return Output(x.screw.u_m, x.screw.u_c, p.x_0 - x.screw.u_c, x.screw.v_m)


model = Continuous(
    "HybridBallScrewDrive",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=2e-5,
)
