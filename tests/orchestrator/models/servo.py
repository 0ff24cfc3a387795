"""A position loop of gain K, solved exactly over a step of constant reference.

    ẋ = K (x_r - x),   x(t + h) = x + (1 - exp(-K h)) (x_r - x)

Source: any textbook (2026).
"""

from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("rad", "position")] = 0.0


class Input(NamedTuple):
    wanted: Annotated[float, Var("rad", "position reference")] = 0.0


class Output(NamedTuple):
    angle: Annotated[float, Var("rad", "position")]


class Parameters(NamedTuple):
    K: Annotated[float, Var("1/s", "position loop gain", min=0)] = 100.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    return State(p.K * (u.wanted - x.x))


def output(x: State, u: Input, p: Parameters) -> Output:
    return Output(x.x)


def advance(x: State, u: Input, p: Parameters, h: float) -> State:
    return State(x.x - np.expm1(-p.K * h) * (u.wanted - x.x))


model = Continuous(
    "Servo", derivative, output, State(), Input(), Parameters(), advance=advance
)
