"""Bipod of which only T1 moves; T2 is clamped at x_2.

    H_1(φ) ẍ_1 + C_d(φ) ẋ_1 + C_m(φ) ẋ_1² + G(φ) + f_c(ẋ_1) = f_1 + f_d tan φ/2

E is kinetic and potential energy, W the work done on the mechanism less what
friction took: E - W stays what it was at first.  Gravity is off unless g is given,
as the source's controllers work on f_1 - G.
Source: Hanifzadegan 2014, eq. 7.9, in the corrected form of ``_mechanism``.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants.bipod._friction import Friction, friction
from plants.bipod._mechanism import (
    Links,
    convective,
    damping,
    distance,
    hanging,
    inertia,
    tangent,
    weight,
)


class State(NamedTuple):
    x_1: Annotated[float, Var("m", "position of slider T1", nominal=0.1)] = 0.0
    v_1: Annotated[float, Var("m/s", "its speed", nominal=1.0)] = 0.0
    W: Annotated[float, Var("J", "work done on the mechanism, less friction")] = 0.0


class Input(NamedTuple):
    f_1: Annotated[float, Var("N", "force on T1", nominal=1e3)] = 0.0
    f_d: Annotated[float, Var("N", "force on the tool table, away from the rail")] = 0.0


class Output(NamedTuple):
    x_1: Annotated[float, Var("m", "position of slider T1")]
    v_1: Annotated[float, Var("m/s", "its speed")]
    phi: Annotated[float, Var("rad", "angle of the rods")]
    E: Annotated[float, Var("J", "kinetic and potential energy")]
    W: Annotated[float, Var("J", "work done on the mechanism, less friction")]


class Parameters(NamedTuple):
    links: Links = Links()
    friction: Friction = Friction()
    x_2: Annotated[float, Var("m", "position of T2: φ is 10 deg at x_1 = 0")] = (
        0.125 + 1.4 * 0.17364817766693033
    )
    g: Annotated[float, Var("m/s2", "gravity, away from the rail")] = 0.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    t, v = tangent(x.x_1, p.x_2, p.links), x.v_1
    H, C_m = inertia(t, p.links), convective(t, p.links)
    lost = damping(t, p.links) * v + friction(v, p.friction)
    driving = u.f_1 + u.f_d * t / 2
    rest = driving - lost - C_m * v * v + weight(t, p.links, p.g)
    return State(v, rest / H, (driving - lost) * v)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return motion and energy."""
    t = tangent(x.x_1, p.x_2, p.links)
    moving: Any = inertia(t, p.links) * x.v_1 * x.v_1 / 2
    E = moving - hanging(p.links) * p.g * distance(t, p.links)
    return Output(x.x_1, x.v_1, np.arctan(t), E, x.W)


model = Continuous(
    "OneSliderBipod", derivative, output, State(), Input(), Parameters(), h_max=5e-5
)
