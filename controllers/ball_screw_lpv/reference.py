"""Reference out and back, limited in velocity, acceleration and jerk.

    r(t) = r_0 + s(t - t_0),   back by the same s after the dwell
    s(t) = J Σ_m (-1)^|m| (t - τ_m)₊³ / 6,   τ_m = Σ_{i in m} T_i

over the 8 subsets m of the times T = (S/V, V/A, A/J): the velocity is a rectangle
smoothed twice, seven segments of constant jerk.  One way takes S/V + V/A + A/J.
Defaults are the reference of chapter 4; chapter 5 goes from 100 to 440 mm.
Source: Hanifzadegan 2014, fig. 4.8 and 5.4; the limit of acceleration is not
stated, 2 m/s² is the end of the axis there.
"""

from fractions import Fraction
from itertools import product
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    r: Annotated[float, Var("m", "table command")]
    v_r: Annotated[float, Var("m/s", "commanded velocity")]
    a_r: Annotated[float, Var("m/s2", "commanded acceleration")]


class Parameters(NamedTuple):
    r_0: Annotated[float, Var("m", "position at rest", fixed=True)] = 0.150
    stroke: Annotated[float, Var("m", "length of the move, signed", fixed=True)] = 0.300
    v_max: Annotated[float, Var("m/s", "velocity V", min=1e-9, fixed=True)] = 0.48
    a_max: Annotated[float, Var("m/s2", "acceleration A", min=1e-9, fixed=True)] = 2.0
    j_max: Annotated[float, Var("m/s3", "jerk J", min=1e-9, fixed=True)] = 20.0
    t_0: Annotated[float, Var("s", "rest before the move", min=0, fixed=True)] = 0.0
    back: Annotated[bool, Var("1", "return after the dwell", fixed=True)] = True
    dwell: Annotated[float, Var("s", "rest before the return", min=0, fixed=True)] = 0.0


def stage_times(p: Parameters) -> tuple[Any, Any, Any]:
    """Return S/V, V/A, A/J (s)."""
    return np.abs(p.stroke) / p.v_max, p.v_max / p.a_max, p.a_max / p.j_max


def move_time(p: Parameters) -> float:
    """Return the duration of one way (s)."""
    return float(sum(stage_times(p)))


def moved(t: Any, p: Parameters) -> tuple[Any, Any, Any]:
    """Return path, velocity and acceleration t seconds after the start of a move."""
    J = np.sign(p.stroke) * p.j_max
    s: Any = 0.0
    v: Any = 0.0
    a: Any = 0.0
    for chosen in product((0, 1), repeat=3):
        tau = sum(T * on for T, on in zip(stage_times(p), chosen, strict=True))
        sign = (-1) ** sum(chosen)
        past = np.maximum(t - tau, 0.0)
        s = s + sign * past**3 / 6
        v = v + sign * past * past / 2
        a = a + sign * past
    return J * s, J * v, J * a


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Evaluate the reference at t = k T_s."""
    t = x.k * T_s - p.t_0
    s_1, v_1, a_1 = moved(t, p)
    s_2, v_2, a_2 = moved(t - (sum(stage_times(p)) + p.dwell), p)
    back: Any = np.where(p.back, 1.0, 0.0)
    r = p.r_0 + (s_1 - back * s_2)
    return State(x.k + 1), Output(r, v_1 - back * v_2, a_1 - back * a_2)


model = Sampled(
    "JerkLimitedReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(9, 25_000),
)
