"""Trajectory generator: a move limited in velocity, acceleration, jerk and snap.

The velocity is a rectangle of length D/V, smoothed by averages over V/A, A/J and
J/S.  With these four times T_i the snap is a train of steps of height S and

    x_r(t) = S Σ_m (-1)^|m| (t - τ_m)₊⁴ / 24,    τ_m = Σ_{i in m} T_i

over the 16 subsets m of the four times.  That sum loses four digits by the end of
the move: 50 mV rms of noise behind a model inversion at 500 mm/s.  Hence once
per parameter change the τ_m are sorted and the Taylor polynomial of each of the
15 segments is formed with twice the digits; a tick evaluates one of them.

The limits are those of the four stages; where the stages overlap (D/V shorter
than the others, or V/A < A/J + J/S) the peaks differ and the snap may reach 2 S.
``back`` returns to zero after ``dwell``.  Time is t = k T_s from the tick k.
Source: Gordon 2010, sec. 3.4 (speeds and 1 g); stroke, jerk and snap are our choice.
"""

from collections import namedtuple
from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.references._double_double import (
    Double2,
    add,
    at_least,
    choose,
    divide,
    exactly,
    multiply,
    subtract,
    two_product,
)
from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The generator needs no input."""


class Output(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")]
    v_r: Annotated[float, Var("rad/s", "commanded velocity")]
    a_r: Annotated[float, Var("rad/s2", "commanded acceleration")]
    j_r: Annotated[float, Var("rad/s3", "commanded jerk")]
    s_r: Annotated[float, Var("rad/s4", "commanded snap")]


class Parameters(NamedTuple):
    stroke: Annotated[float, Var("m", "length of the move, signed", fixed=True)] = 0.25
    v_max: Annotated[float, Var("m/s", "velocity V", min=1e-9, fixed=True)] = 0.5
    a_max: Annotated[float, Var("m/s2", "acceleration A", min=1e-9, fixed=True)] = 9.81
    j_max: Annotated[float, Var("m/s3", "jerk J", min=1e-9, fixed=True)] = 500.0
    s_max: Annotated[float, Var("m/s4", "snap S", min=1e-9, fixed=True)] = 5e4
    t_0: Annotated[float, Var("s", "rest before the move", min=0, fixed=True)] = 0.020
    back: Annotated[bool, Var("1", "return after the dwell", fixed=True)] = False
    dwell: Annotated[float, Var("s", "rest before the return", min=0, fixed=True)] = (
        0.040
    )
    r_g: Annotated[
        float, Var("m/rad", "table motion per screw angle", min=1e-12, fixed=True)
    ] = 0.020 / (2 * np.pi)


class Quartic(NamedTuple):
    """c_0 + c_1 δ + c_2 δ² + c_3 δ³ + c_4 δ⁴."""

    c_0: Double2
    c_1: Double2
    c_2: Double2
    c_3: Double2
    c_4: Double2


class Segment(NamedTuple):
    """x_r as a quartic of the time δ passed ``since``, and its snap."""

    since: Double2
    x_r: Quartic
    s_r: Any


_record: Any = namedtuple
Segments = _record("Segments", [f"after_{i}" for i in range(16)])


class Derived(NamedTuple):
    segments: Any  # one Segment after each of the 16 times
    stroke: Double2
    t_back: Double2


Switch = tuple[Double2, Any]  # a time and the change of snap there, in units of S


def move_time(p: Parameters) -> float:
    """Return the duration of one move, D/V + V/A + A/J + J/S (s)."""
    return float(sum(T.hi for T in stage_times(p)))


def stage_times(p: Parameters) -> tuple[Double2, ...]:
    """Return D/V, V/A, A/J, J/S (s)."""
    rising = (np.abs(p.stroke), p.v_max, p.a_max, p.j_max)
    limits = (p.v_max, p.a_max, p.j_max, p.s_max)
    return tuple(divide(exactly(a), b) for a, b in zip(rising, limits, strict=True))


def switches(p: Parameters) -> list[Switch]:
    """Return the 16 times τ_m in ascending order with their signs."""
    found: list[Switch] = [(exactly(0.0), 1.0)]
    for T in stage_times(p):
        found = merge(found, [(add(tau, T), -sign) for tau, sign in found])
    return found


def merge(a: list[Switch], b: list[Switch]) -> list[Switch]:
    """Merge two ascending lists of one length (Batcher's odd-even network)."""
    if len(a) == 1:
        return list(ordered(a[0], b[0]))
    even, odd = merge(a[::2], b[::2]), merge(a[1::2], b[1::2])
    merged = [even[0]]
    for pair in zip(odd, even[1:], strict=False):
        merged += ordered(*pair)
    return [*merged, odd[-1]]


def ordered(a: Switch, b: Switch) -> tuple[Switch, Switch]:
    """Return two switches, the earlier first."""
    right = at_least(b[0], a[0])
    first = choose(right, a[0], b[0]), np.where(right, a[1], b[1])
    last = choose(right, b[0], a[0]), np.where(right, b[1], a[1])
    return first, last


def prepare(p: Parameters, T_s: float) -> Derived:
    """Return the segments of the move in screw angle, and where it turns."""
    stroke = divide(exactly(p.stroke), p.r_g)
    S = divide(exactly(np.sign(p.stroke) * p.s_max), p.r_g)
    S_24 = divide(S, 24.0)
    zero = exactly(0.0)
    c = [zero] * 5
    n: Any = 0.0
    before = zero
    segments = []
    for tau, sign in switches(p):
        c = shifted(c, subtract(tau, before))
        n = n + sign
        c[4] = multiply(S_24, exactly(n))
        before = tau
        segments.append(Segment(tau, Quartic(*c), n * S.hi))
    # at rest exactly, free of the rounding of fifteen shifts
    segments[-1] = Segment(before, Quartic(stroke, zero, zero, zero, zero), 0.0)
    t_back = add(exactly(p.t_0), add(before, exactly(p.dwell)))
    return Derived(Segments(*segments), stroke, t_back)


def shifted(c: list[Double2], delta: Double2) -> list[Double2]:
    """Return the Taylor coefficients of a quartic at a point delta further on."""
    c = list(c)
    for i in range(4):
        for m in range(3, i - 1, -1):
            c[m] = add(c[m], multiply(delta, c[m + 1]))
    return c


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Evaluate the latest segment at t = k T_s."""
    t = two_product(x.k, T_s)
    returning = np.logical_and(p.back, at_least(t, d.t_back))
    t = subtract(t, choose(returning, d.t_back, exactly(p.t_0)))

    zero = exactly(0.0)
    now = Segment(zero, Quartic(zero, zero, zero, zero, zero), 0.0)
    for segment in d.segments:
        now = choose(at_least(t, segment.since), segment, now)
    delta = subtract(t, now.since)
    c = now.x_r
    x_r = c[4]
    for c_i in c[3::-1]:
        x_r = add(c_i, multiply(delta, x_r))
    x_r = choose(returning, subtract(d.stroke, x_r), x_r)
    way: Any = np.where(returning, -1.0, 1.0)
    h = delta.hi
    v_r = c[1].hi + h * (2 * c[2].hi + h * (3 * c[3].hi + h * 4 * c[4].hi))
    a_r = 2 * c[2].hi + h * (6 * c[3].hi + h * 12 * c[4].hi)
    j_r = 6 * c[3].hi + h * 24 * c[4].hi
    return State(x.k + 1), Output(
        x_r.hi, way * v_r, way * a_r, way * j_r, way * now.s_r
    )


model = Sampled(
    "Trajectory",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
