"""A first-order lag, the smallest continuous FMU with an input and an output.

ẋ = (u - x)/tau, y = x
Source: none; the load of the benchmarks (2026).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("1", "delayed signal")] = 1.0


class Input(NamedTuple):
    u: Annotated[float, Var("1", "signal")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("1", "delayed signal")]


class Parameters(NamedTuple):
    tau: Annotated[float, Var("s", "time constant")] = 0.1


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the change of the delayed signal."""
    return State((u.u - x.x) / p.tau)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the delayed signal."""
    return Output(x.x)


model = Continuous(
    "Lag", derivative, output, State(), Input(), Parameters(), h_max=1e-3
)
