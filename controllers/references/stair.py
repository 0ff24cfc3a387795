"""Step reference, or a stair of equal steps.

    x_r = n h,   n = 0 before t_0, then 1, 2, … up to N, one more every T_d

Source: Maeda 2007, fig. 3-11 to 3-14 and 4-10 to 4-14.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The reference follows the clock alone."""


class Output(NamedTuple):
    x_r: Annotated[float, Var("m", "reference position")]
    v_r: Annotated[float, Var("m/s", "reference velocity, zero")]


class Parameters(NamedTuple):
    height: Annotated[float, Var("m", "height h of a step, signed")] = 1e-3
    t_0: Annotated[float, Var("s", "time of the first step", min=0)] = 0.0
    steps: Annotated[float, Var("1", "number N of steps", min=0)] = 1.0
    dwell: Annotated[float, Var("s", "time T_d on a step", min=1e-9)] = 1.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the reference of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    risen = np.floor(k / tick_of(p.dwell, T_s)) + 1
    n = np.minimum(np.maximum(risen, 0.0), p.steps)
    return State(x.k + 1), Output(p.height * n, 0.0 * n)


model = Sampled(
    "StairReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
