"""Linear-motor axis with what the pure mass leaves out, each part with a switch.

    ḟ = ω_l (u - f),    m_x ẍ = f + f_r(x) + d

With both parts off this is ``plants.gantry.x_axis``; with the amplifier on it is
the axis for which the source's loop shaping adds up (eq. 4.17).
Source: Gordon 2010, sec. 4.3.1, eq. 4.17.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants._modes import lag
from plants.gantry import x_axis as linear_motor
from plants.gantry._motor import Amplifier, Ripple, ripple
from plants.gantry.x_axis import Input, Output


class State(NamedTuple):
    x: Annotated[float, Var("m", "table position", nominal=1e-6)] = 0.0
    v: Annotated[float, Var("m/s", "table velocity", nominal=1e-3)] = 0.0
    f: Annotated[float, Var("V", "motor force as control signal")] = 0.0


class Parameters(NamedTuple):
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=1e-9)] = 0.6977
    amplifier: Amplifier = Amplifier()
    ripple: Ripple = Ripple()


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ: the mass, driven through the parts that are on."""
    f: Any = np.where(p.amplifier.on, x.f, u.u)
    mass = linear_motor.derivative(
        linear_motor.State(x.x, x.v),
        Input(f + ripple(x.x, p.ripple), u.d),
        linear_motor.Parameters(p.m_x),
    )
    return State(*mass, lag(x.f, u.u, p.amplifier.omega_l_hz))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return position and velocity."""
    return Output(x.x, x.v)


model = Continuous(
    "LinearMotorDrive", derivative, output, State(), Input(), Parameters()
)
