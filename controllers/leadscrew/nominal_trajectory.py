"""Nominal characteristic trajectory: the wanted error rate for every error.

    e = x_r - x,   u_p = v_NCT(e) - ẋ            point to point
                   u_p = v_NCT(e) + ẋ_r - ẋ      continuous motion

v_NCT is odd: a table over |e|, straight through the origin, held beyond its end.
ẋ = (x[k] - x[k-1]) / T_s, taken as zero in the first sample.
Source: Maeda 2007, fig. 3-1, 6-1 and 6-2.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import FloatArray, Sampled, Var
from fmus.table import lookup

POINTS = 160


class State(NamedTuple):
    x_1: Annotated[float, Var("mm", "previous position")] = 0.0
    started: Annotated[float, Var("1", "there is a previous position")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("mm", "reference position")] = 0.0
    v_r: Annotated[float, Var("mm/s", "reference velocity")] = 0.0
    x: Annotated[float, Var("mm", "measured position")] = 0.0


class Output(NamedTuple):
    u_p: Annotated[float, Var("mm/s", "distance from the trajectory")]
    e: Annotated[float, Var("mm", "position error")]
    v_nct: Annotated[float, Var("mm/s", "wanted error rate")]


class Parameters(NamedTuple):
    e_nct: Annotated[
        FloatArray, Var("mm", "errors of the trajectory, ascending", fixed=True)
    ] = np.linspace(0.0, 1.0, POINTS)
    edot_nct: Annotated[
        FloatArray, Var("mm/s", "error rates of the trajectory", fixed=True)
    ] = np.linspace(0.0, 16.5, POINTS)
    continuous: Annotated[bool, Var("1", "add the reference velocity")] = False


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the position to remember and the distance from the trajectory."""
    e = u.x_r - u.x
    v_nct = np.sign(e) * lookup(np.abs(e), p.e_nct, p.edot_nct)
    rate: Any = np.where(x.started > 0, (u.x - x.x_1) / T_s, 0.0)
    v_r: Any = np.where(p.continuous, u.v_r, 0.0)
    return State(u.x, 1.0), Output(v_nct + v_r - rate, e, v_nct)


model = Sampled(
    "NCTElement",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
