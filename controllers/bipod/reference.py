"""Pulse profile of the bipod: out over the stroke and back, limited in acceleration.

Acceleration at the start is a trapezoid of height A with flanks t_j, at the reversal
T a triangle of height A over 4V/A, on the way back mirrored; between them speed V.

    T = S/V + t_j/2 + 7V/(6A),    V <= √(S A),    t_j <= V/A

so that the stroke S is met, a short one at less speed.

Source: Hanifzadegan 2014, fig. 7.16 and 7.17 (1.13 m, 10 to 80 deg and back at up to
1 m/s); A and t_j are our choice, fitted to the printed instants of switching.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var

STROKE = -2 * 0.7 * (0.984807753012208 - 0.17364817766693033)  # 2L_s(sin 10° - sin 80°)


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    r: Annotated[float, Var("m", "command to slider T1")]
    v_r: Annotated[float, Var("m/s", "commanded velocity")]
    a_r: Annotated[float, Var("m/s2", "commanded acceleration")]


class Parameters(NamedTuple):
    r_0: Annotated[float, Var("m", "position at rest", fixed=True)] = 0.0
    stroke: Annotated[float, Var("m", "length of the way out, signed", fixed=True)] = (
        STROKE
    )
    V: Annotated[float, Var("m/s", "speed on the way", min=1e-9, fixed=True)] = 1.0
    A: Annotated[float, Var("m/s2", "peak acceleration", min=1e-9, fixed=True)] = 7.0
    t_j: Annotated[float, Var("s", "flank of the start", min=1e-9, fixed=True)] = (
        0.07542
    )
    t_0: Annotated[float, Var("s", "rest before the move", min=0, fixed=True)] = 0.0


def timing(p: Parameters) -> tuple[Any, Any, Any]:
    """Return flank t_j, ramp V/A and reversal T (s), limited as above."""
    S = np.maximum(np.abs(p.stroke), 1e-12)
    V = np.minimum(p.V, np.sqrt(S * p.A))
    t_j = np.minimum(p.t_j, V / p.A)
    return t_j, V / p.A, S / V + t_j / 2 + 7 * V / (6 * p.A)


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Evaluate the reference at t = k T_s."""
    t = x.k * T_s - p.t_0
    rise, ramp, reversal = timing(p)
    way = reversal - np.abs(t - reversal)  # when it was here on its way out
    s: Any = 0.0
    v: Any = 0.0
    a: Any = 0.0
    for begin, jerk in (
        (0.0, p.A / rise),
        (rise, -p.A / rise),
        (ramp, -p.A / rise),
        (ramp + rise, p.A / rise),
        (reversal - 2 * ramp, -p.A / (2 * ramp)),
    ):
        past = np.maximum(way - begin, 0.0)
        s = s + jerk * past**3 / 6
        v = v + jerk * past * past / 2
        a = a + jerk * past
    sign = np.sign(p.stroke)
    v_r: Any = np.where(t <= reversal, v, -v)
    return State(x.k + 1), Output(p.r_0 + sign * s, sign * v_r, sign * a)


model = Sampled(
    "BipodPulseReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 10_000),
)
