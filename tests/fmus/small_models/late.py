"""First-order lag behind an exact dead time, advanced by its own exponential.

    T ẋ = u(t - τ) - x,   x(t + h) = u + (x - u) exp(-h/T)

Source: any textbook (2026).
"""

from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("V", "lagged voltage")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "voltage")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("V", "lagged voltage")]


class Parameters(NamedTuple):
    T: Annotated[float, Var("s", "time constant", min=1e-9)] = 2e-3
    tau: Annotated[float, Var("s", "dead time", min=0)] = 3.7e-4


def derivative(x: State, u: Input, p: Parameters) -> State:
    return State((u.u - x.x) / p.T)


def output(x: State, u: Input, p: Parameters) -> Output:
    return Output(x.x)


def advance(x: State, u: Input, p: Parameters, h: float) -> State:
    return State(u.u + (x.x - u.u) * np.exp(-h / p.T))


model = Continuous(
    "Late",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=1e-3,
    advance=advance,
    delay={"u": "tau"},
)
