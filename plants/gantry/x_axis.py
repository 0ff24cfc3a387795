"""Linear-motor axis on air bearings: a pure mass.

    m_x ẍ = u + d

No friction was observed on the source's machine.  The force is an equivalent
control signal in volts, hence the unit of the mass.
Source: D. Gordon, Precision Control of High Speed Drives using Active Vibration
Damping, MASc thesis, University of Waterloo, 2010, sec. 4.3.1.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("m", "table position", nominal=1e-6)] = 0.0
    v: Annotated[float, Var("m/s", "table velocity", nominal=1e-3)] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "control signal")] = 0.0
    d: Annotated[float, Var("V", "disturbance on the table")] = 0.0


class Output(NamedTuple):
    x: Annotated[float, Var("m", "table position")]
    v: Annotated[float, Var("m/s", "table velocity")]


class Parameters(NamedTuple):
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=1e-9)] = 0.6977


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    return State(x.v, (u.u + u.d) / p.m_x)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return position and velocity."""
    return Output(x.x, x.v)


model = Continuous("LinearMotor", derivative, output, State(), Input(), Parameters())
