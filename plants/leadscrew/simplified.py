"""Simplified object of the NCTF design: an integrator behind a first-order lag.

    X/U = K α_c / (s (s + α_obj)),    ẍ = K α_c u - α_obj ẋ

α_c belongs to the controller's design, α_obj to the object; they are equal where
the trajectory's inclination is the object's own.
Source: Maeda 2007, eq. 3-3, fig. 7-1.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    x: Annotated[float, Var("mm", "position")] = 0.0
    v: Annotated[float, Var("mm/s", "velocity")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("A", "current command")] = 0.0


class Output(NamedTuple):
    x: Annotated[float, Var("mm", "position")]


class Parameters(NamedTuple):
    K: Annotated[float, Var("mm/(A.s)", "gain of the object", min=0)] = 32.3
    alpha_c: Annotated[float, Var("1/s", "inclination of the trajectory", min=0)] = (
        505.0
    )
    alpha_obj: Annotated[float, Var("1/s", "damping of the object", min=0)] = 505.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    return State(x.v, p.K * p.alpha_c * u.u - p.alpha_obj * x.v)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the position."""
    return Output(x.x)


model = Continuous(
    "SimplifiedObject",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=2e-4,
)
