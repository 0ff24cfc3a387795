"""The x and y axes of the machining centre.

    u_c = diag(G_x, G_y) (v_m + (p_t/2π)/(k_t k_a) f_c)

Source: Hanifzadegan 2014, eq. 8.1, 8.18 to 8.21, sec. 8.4.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.three_axis import _axis, _values


class State(NamedTuple):
    x: _axis.State = _axis.at_rest(_values.X)
    y: _axis.State = _axis.at_rest(_values.Y)


class Input(NamedTuple):
    v_mx: Annotated[float, Var("V", "command to x")] = 0.0
    v_my: Annotated[float, Var("V", "command to y")] = 0.0
    f_cx: Annotated[float, Var("N", "force on the table along x")] = 0.0
    f_cy: Annotated[float, Var("N", "force on the table along y")] = 0.0


class Output(NamedTuple):
    u_cx: Annotated[float, Var("m", "table position, x")]
    u_cy: Annotated[float, Var("m", "table position, y")]


class Parameters(NamedTuple):
    x: _axis.Axis = _values.X
    y: _axis.Axis = _values.Y


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ of both axes."""
    return State(
        _axis.derivative(x.x, u.v_mx, u.f_cx, p.x),
        _axis.derivative(x.y, u.v_my, u.f_cy, p.y),
    )


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions."""
    return Output(x.x.u_c, x.y.u_c)


model = Continuous(
    "PlanarMachine", derivative, output, State(), Input(), Parameters(), h_max=2.5e-5
)
