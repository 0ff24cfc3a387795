"""Integrates its input; a second output feeds the input through.

ẋ = u, y = x, z = x + g u
Source: none; a test of the master (2026).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("1", "integral")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("1/s", "rate")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("1", "integral")]
    z: Annotated[float, Var("1/s", "integral and input")]


class Parameters(NamedTuple):
    g: Annotated[float, Var("1", "feed-through")] = 0.0
    one: Annotated[float, Var("1/s", "rate")] = 1.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the input."""
    return State(u.u)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the integral, and with the input fed through."""
    return Output(x.x, p.one * x.x + p.g * u.u)


model = Continuous(
    "Integrator", derivative, output, State(), Input(), Parameters(), h_max=1.0
)
