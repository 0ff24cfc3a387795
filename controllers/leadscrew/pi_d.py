"""PI-D controller: proportional and integral of the error, rate of the position.

    u = K_p e + K_i ∫ e dt - K_d ẋ,    e = x_r - x

ẋ = (x[k] - x[k-1]) / T_s, zero in the first sample; the integral counts the
current sample and is frozen in saturation.
Source: Maeda 2007, fig. 6-3, sec. 6.2.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.leadscrew._frozen_integral import integrated
from controllers.leadscrew.nominal_trajectory import Input
from fmus.model import Sampled, Var


class State(NamedTuple):
    x_1: Annotated[float, Var("mm", "previous position")] = 0.0
    started: Annotated[float, Var("1", "there is a previous position")] = 0.0
    u_i: Annotated[float, Var("A", "integral")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]
    e: Annotated[float, Var("mm", "position error")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("A/mm", "proportional gain")] = 296.94
    K_i: Annotated[float, Var("A/(mm.s)", "integral gain")] = 15829.05
    K_d: Annotated[float, Var("A.s/mm", "gain on the position's rate")] = 1.47
    u_s: Annotated[float, Var("A", "where the actuator saturates", min=0)] = 6.0
    anti_windup: Annotated[bool, Var("1", "freeze the integral")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the position and integral to remember and the current command."""
    e = u.x_r - u.x
    rate: Any = np.where(x.started > 0, (u.x - x.x_1) / T_s, 0.0)
    u_o = p.K_p * e - p.K_d * rate
    u_i = integrated(x.u_i, p.K_i * e, u_o, p.u_s, p.anti_windup, T_s)
    return State(u.x, 1.0, u_i), Output(u_o + u_i, e)


model = Sampled(
    "PI_D",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
