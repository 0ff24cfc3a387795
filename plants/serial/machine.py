"""The serial machine: an x-y table on two uncoupled ball-screw axes of one kind.

Each axis is ``plants.serial.axis``, with its own parameters.
Source: Hanifzadegan 2014, sec. 7.1.2 (two uncoupled identical drives).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv._modal import State as AxisState
from plants.serial import axis


class State(NamedTuple):
    x: AxisState = AxisState()
    y: AxisState = AxisState()


class Input(NamedTuple):
    v_mx: Annotated[float, Var("V", "command to the amplifier of x")] = 0.0
    v_my: Annotated[float, Var("V", "command to the amplifier of y")] = 0.0
    f_cx: Annotated[float, Var("N", "external force along x")] = 0.0
    f_cy: Annotated[float, Var("N", "external force along y")] = 0.0


class Output(NamedTuple):
    u_cx: Annotated[float, Var("m", "table position of x")]
    u_cy: Annotated[float, Var("m", "table position of y")]
    u_mx: Annotated[float, Var("m", "motor position of x as table travel")]
    u_my: Annotated[float, Var("m", "motor position of y as table travel")]
    v_x: Annotated[float, Var("m/s", "speed of x that friction acts on")]
    v_y: Annotated[float, Var("m/s", "speed of y that friction acts on")]


class Parameters(NamedTuple):
    x: axis.Parameters = axis.Parameters()
    y: axis.Parameters = axis.Parameters()


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ of both axes."""
    return State(
        axis.derivative(x.x, axis.Input(u.v_mx, u.f_cx), p.x),
        axis.derivative(x.y, axis.Input(u.v_my, u.f_cy), p.y),
    )


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the positions of both axes."""
    of_x = axis.output(x.x, axis.Input(u.v_mx, u.f_cx), p.x)
    of_y = axis.output(x.y, axis.Input(u.v_my, u.f_cy), p.y)
    return Output(of_x.u_c, of_y.u_c, of_x.u_m, of_y.u_m, of_x.v, of_y.v)


model = Continuous(
    "SerialMachine", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
