"""Rope snap: a static pull on the table is released, a step in d_2.

Before t_0 the drive is taken to hold the pull, so that only the change counts:
d_2 = 0 until t_0, then d_0.
Source: Gordon 2010, sec. 3.4; the size of the pull is not published.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The rope needs no input."""


class Output(NamedTuple):
    d_2: Annotated[float, Var("V", "disturbance on the table")]


class Parameters(NamedTuple):
    d_0: Annotated[float, Var("V", "size of the step")] = 1.0
    t_0: Annotated[float, Var("s", "time of the snap", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the disturbance of this sample."""
    d_2: Any = np.where(x.k >= tick_of(p.t_0, T_s), p.d_0, 0.0)
    return State(x.k + 1), Output(d_2)


model = Sampled(
    "RopeSnap",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
