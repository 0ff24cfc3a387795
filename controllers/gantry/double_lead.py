"""Loop-shaping compensator of the x axis: integrator and two leads.

    v = K (T_i s + 1)/s ((T_d s + 1)/(s/a + 1))² e,    e = x_f - x_m

Pole-zero matched; (T_i s + 1)/s becomes T_s/(e^{T_s/T_i} - 1) + T_s Σ.
Source: Gordon 2010, eq. 4.17, 4.18; default gains for 130 Hz, 35° and -10° with
the amplifier's lag of ``plants.gantry.x_drive``.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters._sections import First, lead, led
from fmus.model import Sampled, Var


class State(NamedTuple):
    w_1: Annotated[float, Var("m", "memory of the first lead")] = 0.0
    w_2: Annotated[float, Var("m", "memory of the second lead")] = 0.0
    e_i: Annotated[float, Var("m.s", "integral of the led error")] = 0.0


class Input(NamedTuple):
    x_f: Annotated[float, Var("m", "command")] = 0.0
    x_m: Annotated[float, Var("m", "reading of the table")] = 0.0


class Output(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")]


class Parameters(NamedTuple):
    K: Annotated[float, Var("V/(m.s)", "gain")] = 6345303.494
    T_i: Annotated[float, Var("s", "reset time", min=1e-9)] = 0.006943173348
    T_d: Annotated[float, Var("s", "lead time of either lead", min=1e-9)] = (
        0.005099446522
    )
    a: Annotated[float, Var("rad/s", "pole of either lead", min=1e-9)] = 3402.275541


class Derived(NamedTuple):
    lead: First
    T_p: Any  # proportional part of the integrator with zero (s)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match the compensator at the sample time."""
    return Derived(lead(1 / p.T_d, p.a, T_s), T_s / np.expm1(T_s / p.T_i))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the feedback signal of this sample."""
    w_1, e = led(x.w_1, u.x_f - u.x_m, d.lead)
    w_2, e = led(x.w_2, e, d.lead)
    e_i = x.e_i + T_s * e
    return State(w_1, w_2, e_i), Output(p.K * (d.T_p * e + e_i))


model = Sampled(
    "DoubleLead",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
