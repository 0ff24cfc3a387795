"""Open-loop current pulse, then braking by a derivative controller.

    u = u_r         0 <= t - t_0 < t_r
    u = -K_d ẋ      from then on,    ẋ = (x[k] - x[k-1]) / T_s

The amplifier saturates at the beginning; as the speed falls the current fades softly
and the mechanism comes to rest without turning back.  What the fading pulse of
``controllers.references.current_pulse`` imitates.
Source: Maeda 2007, fig. 5-2a; K_d is not published.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0
    x_1: Annotated[float, Var("mm", "previous position")] = 0.0


class Input(NamedTuple):
    x: Annotated[float, Var("mm", "measured position")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]


class Parameters(NamedTuple):
    u_r: Annotated[float, Var("A", "height of the pulse")] = 6.0
    t_r: Annotated[float, Var("s", "duration of the pulse", min=0)] = 0.25
    t_0: Annotated[float, Var("s", "rest before the pulse", min=0)] = 0.0
    K_d: Annotated[float, Var("A.s/mm", "gain on the speed", min=0)] = 0.1


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the position to remember and the current of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    k_r = tick_of(p.t_r, T_s)
    rate: Any = np.where(k > k_r, (u.x - x.x_1) / T_s, 0.0)
    pulsing = np.logical_and(k >= 0, k < k_r)
    u_now: Any = np.where(pulsing, p.u_r, -p.K_d * rate)
    return State(x.k + 1, u.x), Output(u_now)


model = Sampled(
    "DerivativeBraking",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
