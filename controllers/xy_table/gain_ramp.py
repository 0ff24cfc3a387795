"""Factor on a loop's gain that rises slowly, to find the limit of stability.

    g = g_0 + r (t - t_0),    t >= t_0

Source: ours.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The ramp follows the clock alone."""


class Output(NamedTuple):
    g: Annotated[float, Var("1", "factor on the gain")]


class Parameters(NamedTuple):
    g_0: Annotated[float, Var("1", "factor at the start")] = 1.0
    r: Annotated[float, Var("1/s", "its rate")] = 1.0
    t_0: Annotated[float, Var("s", "rest before the ramp", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the factor of this sample."""
    g = p.g_0 + p.r * np.maximum(x.k * T_s - p.t_0, 0.0)
    return State(x.k + 1), Output(g)


model = Sampled(
    "GainRamp",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
)
