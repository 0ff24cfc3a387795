"""One axis of an XY ball-screw table, identified from its frequency response.

    ÿ = b u(t - τ) - a_1 ẏ - a_0 y,     Y/U = b e^{-τs} / (s² + a_1 s + a_0)

Positions are in millimetres.  A disturbance d enters beside u, scaled to volts
by the source's undefined K_f (d = D/K_f); the dead time holds for both.

Source: Anang, Jamaludin, Abdullah, Maharof, Nordin, Robust Motion Controller
Design for Precise Tracking of Ball Screw Driven Positioning System, Journal of
Advanced Manufacturing Technology, 2018, eq. 1, 8.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    y: Annotated[float, Var("mm", "table position")] = 0.0
    v: Annotated[float, Var("mm/s", "table velocity")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "control signal")] = 0.0
    d: Annotated[float, Var("V", "disturbance as control signal")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("mm", "table position")]
    v: Annotated[float, Var("mm/s", "table velocity")]


class Parameters(NamedTuple):
    b: Annotated[float, Var("mm/(V.s2)", "numerator of G_m", min=0)] = 78020.0
    a_1: Annotated[float, Var("1/s", "coefficient of s", min=0)] = 163.0
    a_0: Annotated[float, Var("1/s2", "constant of the denominator", min=0)] = 193.3
    tau: Annotated[float, Var("s", "dead time", min=0)] = 1.2e-3


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ; the inputs are already late."""
    return State(x.v, p.b * (u.u + u.d) - p.a_1 * x.v - p.a_0 * x.y)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return position and velocity."""
    return Output(x.y, x.v)


model = Continuous(
    "XYTableAxis",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=5e-5,
    delay={"u": "tau", "d": "tau"},
)
