"""Bipod with both sliders moving, and the path of its tool table T3.

    [H_1 H_12; H_12 H_2] (ẍ_1, ẍ_2) = (f_1 + q, f_2 - q) - b_x (ẋ_1, ẋ_2) - f_c
    q = f_d tan φ/2 + C_φ w - C_m w² - G,     w = ẋ_2 - ẋ_1
    x = (x_1 + x_2)/2,     y = L_s cos φ

E and W as in ``one_slider``.  The determinant m_a m_c - m_d² + h(m_a + m_c + 2m_d) is
written so that nothing cancels where h is large.
Source: Hanifzadegan 2014, eq. 7.6 and 7.7, in the corrected form of ``_mechanism``.
"""

from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants.bipod._friction import Friction, friction
from plants.bipod._mechanism import (
    Links,
    convective,
    coupling,
    distance,
    hanging,
    inertia,
    inertia_2,
    joints,
    tangent,
    turning,
    weight,
)

X_2 = 0.125 + 1.4 * 0.17364817766693033  # φ = 10 deg at x_1 = 0


class State(NamedTuple):
    x_1: Annotated[float, Var("m", "position of slider T1", nominal=0.1)] = 0.0
    v_1: Annotated[float, Var("m/s", "its speed", nominal=1.0)] = 0.0
    x_2: Annotated[float, Var("m", "position of slider T2", nominal=0.1)] = X_2
    v_2: Annotated[float, Var("m/s", "its speed", nominal=1.0)] = 0.0
    W: Annotated[float, Var("J", "work done on the mechanism, less friction")] = 0.0


class Input(NamedTuple):
    f_1: Annotated[float, Var("N", "force on T1", nominal=1e3)] = 0.0
    f_2: Annotated[float, Var("N", "force on T2", nominal=1e3)] = 0.0
    f_d: Annotated[float, Var("N", "force on the tool table, away from the rail")] = 0.0


class Output(NamedTuple):
    x_1: Annotated[float, Var("m", "position of slider T1")]
    v_1: Annotated[float, Var("m/s", "its speed")]
    x_2: Annotated[float, Var("m", "position of slider T2")]
    v_2: Annotated[float, Var("m/s", "its speed")]
    phi: Annotated[float, Var("rad", "angle of the rods")]
    x: Annotated[float, Var("m", "tool table along the rail")]
    y: Annotated[float, Var("m", "tool table from the rail")]
    E: Annotated[float, Var("J", "kinetic and potential energy")]
    W: Annotated[float, Var("J", "work done on the mechanism, less friction")]


class Parameters(NamedTuple):
    links: Links = Links()
    friction: Friction = Friction()
    g: Annotated[float, Var("m/s2", "gravity, away from the rail")] = 0.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    t, w = tangent(x.x_1, x.x_2, p.links), x.v_2 - x.v_1
    lost_1 = p.links.b_x * x.v_1 + friction(x.v_1, p.friction)
    lost_2 = p.links.b_x * x.v_2 + friction(x.v_2, p.friction)
    parting = joints(t, p.links) * w
    q = u.f_d * t / 2 + parting
    work = (u.f_1 + q - lost_1) * x.v_1 + (u.f_2 - q - lost_2) * x.v_2
    q = q - convective(t, p.links) * w * w + weight(t, p.links, p.g)
    f_1, f_2 = u.f_1 + q - lost_1, u.f_2 - q - lost_2
    H_1, H_2 = inertia(t, p.links), inertia_2(t, p.links)
    H_12, h = coupling(t, p.links), turning(t, p.links)
    m_a, m_c, m_d = H_1 - h, H_2 - h, H_12 + h
    determinant = m_a * m_c - m_d * m_d + h * (m_a + m_c + 2 * m_d)
    a_1 = (H_2 * f_1 - H_12 * f_2) / determinant
    a_2 = (H_1 * f_2 - H_12 * f_1) / determinant
    return State(x.v_1, a_1, x.v_2, a_2, work)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return motion, tool table and energy."""
    t = tangent(x.x_1, x.x_2, p.links)
    y = distance(t, p.links)
    moving = inertia(t, p.links) * x.v_1**2 + inertia_2(t, p.links) * x.v_2**2
    moving = moving / 2 + coupling(t, p.links) * x.v_1 * x.v_2
    E = moving - hanging(p.links) * p.g * y
    tool = (x.x_1 + x.x_2) / 2
    return Output(x.x_1, x.v_1, x.x_2, x.v_2, np.arctan(t), tool, y, E, x.W)


model = Continuous(
    "TwoSliderBipod", derivative, output, State(), Input(), Parameters(), h_max=5e-5
)
