"""Current loop of the amplifier as a first-order lag.

    u̇_a = ω (u - u_a)

Source: Gordon 2010, sec. 3.2.1 (bandwidth 450 Hz; the order is our choice).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants._modes import lag


class State(NamedTuple):
    u_a: Annotated[float, Var("V", "torque as control signal")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "control signal")] = 0.0


class Output(NamedTuple):
    u_a: Annotated[float, Var("V", "torque as control signal")]


class Parameters(NamedTuple):
    omega_hz: Annotated[float, Var("Hz", "bandwidth", min=0)] = 450.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the rate of the torque."""
    return State(lag(x.u_a, u.u, p.omega_hz))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the torque."""
    return Output(x.u_a)


model = Continuous("CurrentLoop", derivative, output, State(), Input(), Parameters())
