"""Position loop of the cascade NP/PI: proportional, its gain growing with the error.

    e = z_ref - y,    v_ref = (k_v N g) e,    N = cosh(KO e),    |e| <= e_max in N

KO = 0 is the position loop of the cascade P/PI.  g is 1 but in gain tests.
Source: Anang et al. 2018, eq. 5, table 1 (e in mm; beyond e_max N is held).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    """The position loop has no memory."""


class Input(NamedTuple):
    z_ref: Annotated[float, Var("mm", "position reference")] = 0.0
    y: Annotated[float, Var("mm", "position")] = 0.0
    g: Annotated[float, Var("1", "factor on k_v in gain tests")] = 1.0


class Output(NamedTuple):
    v_ref: Annotated[float, Var("mm/s", "velocity reference")]
    e: Annotated[float, Var("mm", "tracking error")]
    N: Annotated[float, Var("1", "nonlinear gain")]


class Parameters(NamedTuple):
    k_v: Annotated[float, Var("1/s", "position gain")] = 225.0
    KO: Annotated[
        float, Var("1/mm", "rate of variation of the nonlinear gain", min=0)
    ] = 3.5
    e_max: Annotated[float, Var("mm", "error beyond which N is held", min=0)] = 0.5


def nonlinear_gain(e: Any, KO: Any, e_max: Any) -> Any:
    """Return N(e) of eq. 5, held beyond e_max (mm)."""
    return np.cosh(KO * np.minimum(np.maximum(e, -e_max), e_max))


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the velocity reference of this sample."""
    e = u.z_ref - u.y
    N = nonlinear_gain(e, p.KO, p.e_max)
    return x, Output((p.k_v * (N * u.g)) * e, e, N)


model = Sampled(
    "NPPosition",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
)
