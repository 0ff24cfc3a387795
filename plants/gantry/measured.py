"""The gantry with what ``drive`` still leaves out, each behind a switch.

    f_i = u_i + w_i                                      noise of the amplifiers
    m_q (q̈ + 2ζω q̇ + ω² q) = φ_1 f_1 + φ_2 f_2 + φ_t d_t    pitch of the table, 216 Hz
    y_t + d_t/k_t                                        flexibility of the table
    J θ̈ = ... + h f_x                                    the x motor's reaction

The pitch is a mode like the base's; the encoders do not see it (φ_1 = φ_2 = 0), a
hammer on the table does.  f_x is the force of the x motor; its line passes the centre
of mass at h.  A base that a rope pulled from outside leaves alone has φ_t = 0, which
is the default here.  With all parts off this is ``plants.gantry.drive``.
Source: Gordon 2010, sec. 4.3.3 (216 Hz by hammer alone), 4.5 (32.5 N/μm), ch. 5
(coupling named); h, the pitch's mass and damping, and the newtons of a volt (54, on
which the MIMO peak of the rope snap was met) are ours.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Included, Var
from plants.gantry import drive as gantry_drive
from plants.gantry import frame as gantry
from plants.gantry.drive import Mode, deflection
from plants.gantry.frame import Output

BASE = Mode(phi_t=0.0)


class State(NamedTuple):
    drive: Annotated[gantry_drive.State, Included()] = gantry_drive.State()
    q_p: Annotated[float, Var("m", "pitch at the table", nominal=1e-6)] = 0.0
    v_p: Annotated[float, Var("m/s", "its rate", nominal=1e-3)] = 0.0


class Input(NamedTuple):
    u_1: Annotated[float, Var("V", "control signal of the left motor")] = 0.0
    u_2: Annotated[float, Var("V", "control signal of the right motor")] = 0.0
    d_t: Annotated[float, Var("V", "disturbance at the table")] = 0.0
    x: Annotated[float, Var("m", "table position along the gantry")] = 0.0
    f_x: Annotated[float, Var("V", "force of the x motor")] = 0.0
    w_1: Annotated[float, Var("V", "noise of the left amplifier")] = 0.0
    w_2: Annotated[float, Var("V", "noise of the right amplifier")] = 0.0


class Flexibility(NamedTuple):
    on: Annotated[bool, Var("1", "the table gives way")] = False
    k_t: Annotated[float, Var("V/m", "its stiffness", min=1e-9)] = 32.5e6 / 54


class Coupling(NamedTuple):
    on: Annotated[bool, Var("1", "the x motor's reaction turns the gantry")] = False
    h: Annotated[float, Var("m", "lever of its line about the centre of mass")] = 0.05


class Parameters(NamedTuple):
    drive: Annotated[gantry_drive.Parameters, Included()] = gantry_drive.Parameters(
        base=BASE
    )
    pitch: Mode = Mode(False, 216.0, 0.02, 50.0, 0.0, 0.0, 1.0)
    flexibility: Flexibility = Flexibility()
    coupling: Coupling = Coupling()


def driven(u: Input) -> gantry.Input:
    """Return the inputs of the drive: control signals with the amplifiers' noise."""
    return gantry.Input(u.u_1 + u.w_1, u.u_2 + u.w_2, u.d_t, u.x)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ: the drive, turned by the x motor, and the pitch."""
    inputs = driven(u)
    rates = gantry_drive.derivative(x.drive, inputs, p.drive)
    g = gantry.geometry(u.x, gantry_drive.mechanics(p.drive))
    yaw: Any = np.where(p.coupling.on, p.coupling.h * u.f_x / g.J, 0.0)
    turned = rates._replace(v_1=rates.v_1 - g.a_1 * yaw, v_2=rates.v_2 + g.a_2 * yaw)
    return State(turned, *deflection(x.q_p, x.v_p, inputs, p.pitch))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return what the encoders and an interferometer at the table see."""
    y = gantry_drive.output(x.drive, driven(u), p.drive)
    gives: Any = np.where(p.flexibility.on, u.d_t / p.flexibility.k_t, 0.0)
    pitch: Any = np.where(p.pitch.on, x.q_p, 0.0)
    rate: Any = np.where(p.pitch.on, x.v_p, 0.0)
    one, two = p.pitch.phi_1, p.pitch.phi_2
    y_1, y_2 = y.y_1 + one * pitch, y.y_2 + two * pitch
    y_t = y.y_t + p.pitch.phi_t * pitch + gives
    theta = (y_2 - y_1) / p.drive.L
    return Output(y_1, y_2, y.v_1 + one * rate, y.v_2 + two * rate, y_t, theta)


model = Continuous("GantryMeasured", derivative, output, State(), Input(), Parameters())
