"""Two filters of three states, scheduled by tables of matrices, as arrays of signals.

    ẋ = A(ρ) x + B(ρ) u,   y = C x,   Y = x xᵀ C₁

Source: any textbook (2026).
"""

from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Continuous, FloatArray, Var
from fmus.table import lookup_rows, slopes


class State(NamedTuple):
    x: Annotated[FloatArray, Var("V", "filter states", nominal=0.1)] = np.zeros(3)


class Input(NamedTuple):
    u: Annotated[FloatArray, Var("V", "two voltages")] = np.array([0.5, -1.0])
    rho: Annotated[float, Var("m", "scheduling variable")] = 0.25


class Output(NamedTuple):
    y: Annotated[FloatArray, Var("V", "filtered voltages")]
    Y: Annotated[FloatArray, Var("V2", "products of the states")]
    last: Annotated[float, Var("V", "last state")]


class Parameters(NamedTuple):
    A: Annotated[FloatArray, Var("1/s", "system matrices", fixed=True)] = np.vstack(
        [np.array([[-90.0, k, 3], [-k, -80, 1], [2, k, -70]]) for k in (5, 60, -30)]
    )
    B: Annotated[FloatArray, Var("1/s", "input matrices", constant=True)] = np.vstack(
        [np.array([[k, 1.0], [2, k], [0, 5]]) for k in (50, 20, 80)]
    )
    C: Annotated[FloatArray, Var("1", "output matrix")] = np.array(
        [[1.0, 0.0, 2.0], [0.0, 1.0, -1.0]]
    )
    at: Annotated[FloatArray, Var("m", "breakpoints", fixed=True)] = np.array(
        [0.2, 0.3, 0.6]
    )


class Derived(NamedTuple):
    A: FloatArray


def prepare(p: Parameters) -> Derived:
    return Derived(slopes(p.at, p.A))


def derivative(x: State, u: Input, p: Parameters, d: Derived) -> State:
    A = lookup_rows(u.rho, p.at, p.A, d.A)
    B = lookup_rows(u.rho, p.at, p.B)
    return State(A @ x.x + B @ u.u)


def output(x: State, u: Input, p: Parameters, d: Derived) -> Output:
    return Output(p.C @ x.x, np.outer(x.x, p.C[0, :]), x.x[-1])


model = Continuous(
    "Scheduled",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    h_max=1e-4,
    prepare=prepare,
)
