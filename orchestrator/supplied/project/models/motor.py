"""A motor with viscous friction under a load torque.

J ω̇ = K_t i - B ω - τ_L
Source: none; an example of a plant of your own.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    omega: Annotated[float, Var("rad/s", "speed")] = 0.0


class Input(NamedTuple):
    i: Annotated[float, Var("A", "current")] = 0.0
    tau_L: Annotated[float, Var("N.m", "load torque")] = 0.0


class Output(NamedTuple):
    omega: Annotated[float, Var("rad/s", "speed")]


class Parameters(NamedTuple):
    J: Annotated[float, Var("kg.m2", "inertia", min=1e-9)] = 1e-3
    B: Annotated[float, Var("N.m.s/rad", "viscous friction", min=0.0)] = 1e-4
    K_t: Annotated[float, Var("N.m/A", "torque constant")] = 0.5


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the acceleration."""
    return State((p.K_t * u.i - p.B * x.omega - u.tau_L) / p.J)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the speed."""
    return Output(x.omega)


model = Continuous("Motor", derivative, output, State(), Input(), Parameters())
