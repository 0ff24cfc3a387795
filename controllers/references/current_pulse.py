"""Open-loop current pulse for identifying a mechanism, with or without braking.

    u = u_r          0 <= t - t_0 < t_r
    u = -u_b b(t')   0 <= t' < t_b,   t' = t - t_0 - t_r,   then 0

b = 1, or (1 + cos(π t'/t_b)) / 2 where the braking fades out.
Source: Maeda 2007, fig. 3-2 (no braking), 5-2 and 5-3; the pulse's shape is only
in a figure, the raised cosine is our choice.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The pulse follows the clock alone."""


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]


class Parameters(NamedTuple):
    u_r: Annotated[float, Var("A", "height of the pulse")] = 5.0
    t_r: Annotated[float, Var("s", "duration of the pulse", min=0)] = 0.3
    t_0: Annotated[float, Var("s", "rest before the pulse", min=0)] = 0.0
    u_b: Annotated[float, Var("A", "height of the braking")] = 0.0
    t_b: Annotated[float, Var("s", "duration of the braking", min=1e-9)] = 0.1
    fading: Annotated[bool, Var("1", "the braking fades out")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the current of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    k_r = tick_of(p.t_r, T_s)
    t = (k - k_r) * T_s
    fading = (1 + np.cos(np.pi * t / p.t_b)) / 2
    braking: Any = np.where(
        np.logical_and(k >= k_r, t < p.t_b * (1 - 1e-9)),
        -p.u_b * np.where(p.fading, fading, 1.0),
        0.0,
    )
    pulsing = np.logical_and(k >= 0, k < k_r)
    u_now: Any = np.where(pulsing, p.u_r, braking)
    return State(x.k + 1), Output(u_now)


model = Sampled(
    "CurrentPulse",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
