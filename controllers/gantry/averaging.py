"""Sensor and actuator averaging with active damping and integral action per end.

    e_i = y_if - y_im,    e_c = α_1 e_1 + α_2 e_2
    v_1 = α_1 (K (T_d s + 1)/(s/a + 1) e_c + β s (e_1 - e_2) + k_i/s e_1)
    v_2 = α_2 (K (T_d s + 1)/(s/a + 1) e_c + β s (e_2 - e_1) + k_i/s e_2)

The lead is pole-zero matched, s a backward difference, 1/s the trapezoidal rule.
Source: Gordon 2010, eq. 4.25 to 4.30 without h; default gains for 60 Hz and 40°,
590 % more yaw damping and our choice of k_i.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.filters._sections import First, lead, led
from fmus.model import Sampled, Var


class State(NamedTuple):
    w_c: Annotated[float, Var("m", "memory of the lead")] = 0.0
    e_d: Annotated[float, Var("m", "previous difference of the errors")] = 0.0
    e_1i: Annotated[float, Var("m.s", "integral of the left error")] = 0.0
    e_2i: Annotated[float, Var("m.s", "integral of the right error")] = 0.0


class Input(NamedTuple):
    y_1f: Annotated[float, Var("m", "command of the left end")] = 0.0
    y_2f: Annotated[float, Var("m", "command of the right end")] = 0.0
    y_1m: Annotated[float, Var("m", "reading of the left end")] = 0.0
    y_2m: Annotated[float, Var("m", "reading of the right end")] = 0.0
    alpha_1: Annotated[float, Var("1", "share of the mass at the left end")] = 0.5
    alpha_2: Annotated[float, Var("1", "share of the mass at the right end")] = 0.5


class Output(NamedTuple):
    v_1: Annotated[float, Var("V", "feedback signal of the left motor")]
    v_2: Annotated[float, Var("V", "feedback signal of the right motor")]


class Parameters(NamedTuple):
    K: Annotated[float, Var("V/m", "gain on the averaged error")] = 116158.8004
    T_d: Annotated[float, Var("s", "lead time", min=1e-9)] = 0.004709660418
    a: Annotated[float, Var("rad/s", "pole of the lead", min=1e-9)] = 669.3477867
    beta: Annotated[float, Var("V.s/m", "active damping")] = 49.03546478
    k_i: Annotated[float, Var("V/(m.s)", "integral gain of either end")] = 1e7


def prepare(p: Parameters, T_s: float) -> First:
    """Match the lead at the sample time."""
    return lead(1 / p.T_d, p.a, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: First
) -> tuple[State, Output]:
    """Return both feedback signals of this sample."""
    e_1, e_2 = u.y_1f - u.y_1m, u.y_2f - u.y_2m
    w_c, e_c = led(x.w_c, u.alpha_1 * e_1 + u.alpha_2 * e_2, d)
    e_d = e_1 - e_2
    twist = p.beta * (e_d - x.e_d) / T_s
    e_1i, e_2i = x.e_1i + T_s / 2 * e_1, x.e_2i + T_s / 2 * e_2
    v_1 = u.alpha_1 * (p.K * e_c + twist + p.k_i * e_1i)
    v_2 = u.alpha_2 * (p.K * e_c - twist + p.k_i * e_2i)
    x_next = State(w_c, e_d, e_1i + T_s / 2 * e_1, e_2i + T_s / 2 * e_2)
    return x_next, Output(v_1, v_2)


model = Sampled(
    "GantryAveraging",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
