"""Cutting force of a slotting pass, as equivalent voltage on the table.

    d_2 = -(d_m + d_s sin 2π f_s t + d_t sin 2π z f_s t),    t_on <= t < t_off

Four flutes in a full slot give an almost constant feed force; what is left of the
ripple is run-out at spindle frequency f_s and the passing of the z teeth.
Source: Gordon 2010, sec. 3.4 (3500 rpm, 4 flutes, in the cut from 0.6 to 1.2 s);
no force is published, the amplitudes are our choice.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import sine, tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The force follows the clock alone."""


class Output(NamedTuple):
    d_2: Annotated[float, Var("V", "disturbance on the table")]


class Parameters(NamedTuple):
    d_m: Annotated[float, Var("V", "mean feed force")] = 0.25
    d_s: Annotated[float, Var("V", "amplitude at spindle frequency")] = 0.02
    d_t: Annotated[float, Var("V", "amplitude at tooth passing")] = 0.01
    f_s_hz: Annotated[float, Var("Hz", "spindle frequency", min=0)] = 3500 / 60
    z: Annotated[float, Var("1", "number of flutes", min=1)] = 4.0
    t_on: Annotated[float, Var("s", "tool enters the cut", min=0)] = 0.6
    t_off: Annotated[float, Var("s", "tool leaves the cut", min=0)] = 1.2


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the force of this sample."""
    ripple = p.d_s * sine(p.f_s_hz, x.k, T_s)
    ripple = ripple + p.d_t * sine(p.z * p.f_s_hz, x.k, T_s)
    entered = x.k >= tick_of(p.t_on, T_s)
    cutting = np.logical_and(entered, x.k < tick_of(p.t_off, T_s))
    d_2: Any = np.where(cutting, -(p.d_m + ripple), 0.0)
    return State(x.k + 1), Output(d_2)


model = Sampled(
    "SlottingForce",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
