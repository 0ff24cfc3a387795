"""Ball-screw drive as two masses joined by the screw's axial compliance.

    m_1 ẍ_1 = -b_1 ẋ_1 + k (x_2 - x_1) + c (ẋ_2 - ẋ_1) + u + d_1
    m_2 ẍ_2 = -b_2 ẋ_2 + k (x_1 - x_2) + c (ẋ_1 - ẋ_2) + d_2

Positions are screw angles: x_1 of the screw, x_2 of the table as equivalent
rotation.  Torque and forces are equivalent control signals in volts.  m_12
makes the mass matrix full.

Source: D. Gordon, Precision Control of High Speed Drives using Active Vibration
Damping, MASc thesis, University of Waterloo, 2010, eq. 3.1, 3.2, table 3.1.
"""

from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Continuous, Var


class State(NamedTuple):
    x_1: Annotated[float, Var("rad", "screw angle")] = 0.0
    x_2: Annotated[float, Var("rad", "table position as screw angle")] = 0.0
    v_1: Annotated[float, Var("rad/s", "screw speed")] = 0.0
    v_2: Annotated[float, Var("rad/s", "table speed as screw speed")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "control signal")] = 0.0
    d_1: Annotated[float, Var("V", "disturbance on the screw")] = 0.0
    d_2: Annotated[float, Var("V", "disturbance on the table")] = 0.0


class Output(NamedTuple):
    x_1: Annotated[float, Var("rad", "screw angle")]
    x_2: Annotated[float, Var("rad", "table position as screw angle")]
    v_1: Annotated[float, Var("rad/s", "screw speed")]
    v_2: Annotated[float, Var("rad/s", "table speed as screw speed")]
    x_t: Annotated[float, Var("m", "table position")]


class Parameters(NamedTuple):
    m_1: Annotated[float, Var("V.s2/rad", "rotating inertia", min=1e-9)] = 1.858e-3
    m_2: Annotated[float, Var("V.s2/rad", "translating inertia", min=1e-9)] = 0.379e-3
    b_1: Annotated[float, Var("V.s/rad", "damping of motor and bearings", min=0)] = (
        1.020e-3
    )
    b_2: Annotated[float, Var("V.s/rad", "damping of the guideways", min=0)] = 0.0
    k: Annotated[float, Var("V/rad", "axial stiffness", min=0)] = 210.02
    c: Annotated[float, Var("V.s/rad", "damping of the nut", min=0)] = 0.014
    m_12: Annotated[float, Var("V.s2/rad", "coupling of the inertias")] = 0.0
    r_g: Annotated[float, Var("m/rad", "table motion per screw angle", min=0)] = (
        0.020 / (2 * np.pi)
    )


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ (eq. 3.1; with m_12 eq. 3.2)."""
    nut = p.k * (x.x_2 - x.x_1) + p.c * (x.v_2 - x.v_1)
    f_1 = -p.b_1 * x.v_1 + nut + u.u + u.d_1
    f_2 = -p.b_2 * x.v_2 - nut + u.d_2
    ratio = p.m_12 / p.m_2
    a_1 = (f_1 - ratio * f_2) / (p.m_1 - ratio * p.m_12)
    a_2 = (f_2 - p.m_12 * a_1) / p.m_2
    return State(x.v_1, x.v_2, a_1, a_2)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions and speeds, and the table position in metres."""
    return Output(x.x_1, x.x_2, x.v_1, x.v_2, p.r_g * x.x_2)


model = Continuous("BallScrew", derivative, output, State(), Input(), Parameters())
