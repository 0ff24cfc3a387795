"""A mass on a spring with a switchable second spring, held force.

    m ẍ = F - k x - c ẋ - s k_2 x

Source: any textbook (2026).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("m", "position", nominal=0.01)] = 0.01
    v: Annotated[float, Var("m/s", "velocity")] = 0.0


class Input(NamedTuple):
    F: Annotated[float, Var("N", "force")] = 0.0


class Output(NamedTuple):
    position: Annotated[float, Var("um", "position in micrometres")]
    felt: Annotated[float, Var("N", "force in the springs and the drive")]


class Parameters(NamedTuple):
    m: Annotated[float, Var("kg", "mass", min=1e-3)] = 2.0
    k: Annotated[float, Var("N/m", "stiffness", min=0)] = 5e4
    k_2: Annotated[float, Var("N/m", "second stiffness", min=0, fixed=True)] = 2e4
    c: Annotated[float, Var("N.s/m", "damping", min=0)] = 40.0
    second: Annotated[bool, Var("1", "second spring attached")] = True
    scale: Annotated[float, Var("um/m", "display scale", constant=True)] = 1e6


def spring_force(x: State, p: Parameters) -> float:
    """Return the force of both springs (N)."""
    return (p.k + p.second * p.k_2) * x.x


def derivative(x: State, u: Input, p: Parameters) -> State:
    return State(x.v, (u.F - spring_force(x, p) - p.c * x.v) / p.m)


def output(x: State, u: Input, p: Parameters) -> Output:
    return Output(p.scale * x.x, spring_force(x, p) + 0.5 * u.F)


model = Continuous(
    "SpringMass", derivative, output, State(), Input(), Parameters(), h_max=1e-4
)
