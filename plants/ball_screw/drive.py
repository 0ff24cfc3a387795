"""The ball-screw drive with what the two-mass model leaves out.

Each part has a switch; with all of them off this is ``plants.ball_screw.two_mass``.

    u̇_a = ω_cl (u - u_a)                              current loop
    d_1 ← d_1 - d(ẋ_1)                                 Stribeck friction of the screw
    y_1 = x_1 + Σ q_i,  q̈_i + 2ζω_i q̇_i + ω_i² q_i = r_i u_a     torsional modes
    y_2 = x_2 + q,      q̈ + 2ζω q̇ + ω² q = γ ω² d_2            pitch of the table

The outputs x_1, x_2 are what the encoders see, y_1 and y_2 above.
Source: Gordon 2010, eq. 2.1, 3.1, sec. 3.2.1 (450 Hz; 440, 1100 Hz; 43 Hz);
the modes' damping and residues and the friction's levels are our choice.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants._modes import acceleration, lag
from plants.ball_screw import pitch_mode
from plants.ball_screw import two_mass as ball_screw
from plants.ball_screw._friction import Stribeck, friction
from plants.ball_screw.two_mass import Input, Output


class State(NamedTuple):
    x_1: Annotated[float, Var("rad", "screw angle")] = 0.0
    x_2: Annotated[float, Var("rad", "table position as screw angle")] = 0.0
    v_1: Annotated[float, Var("rad/s", "screw speed")] = 0.0
    v_2: Annotated[float, Var("rad/s", "table speed as screw speed")] = 0.0
    u_a: Annotated[float, Var("V", "torque as control signal")] = 0.0
    q: Annotated[float, Var("rad", "pitch at the encoder as screw angle")] = 0.0
    v_q: Annotated[float, Var("rad/s", "rate of the pitch")] = 0.0
    q_1: Annotated[float, Var("rad", "first torsional mode")] = 0.0
    v_q1: Annotated[float, Var("rad/s", "its rate")] = 0.0
    q_2: Annotated[float, Var("rad", "second torsional mode")] = 0.0
    v_q2: Annotated[float, Var("rad/s", "its rate")] = 0.0


class CurrentLoop(NamedTuple):
    on: Annotated[bool, Var("1", "current loop has a lag")] = False
    omega_hz: Annotated[float, Var("Hz", "bandwidth", min=0)] = 450.0


class Pitch(NamedTuple):
    on: Annotated[bool, Var("1", "table pitches")] = False
    omega_hz: Annotated[float, Var("Hz", "natural frequency", min=0)] = 43.0
    zeta: Annotated[float, Var("1", "damping ratio", min=0)] = 0.02
    gamma: Annotated[float, Var("rad/V", "static compliance")] = 1e-3


class Torsion(NamedTuple):
    on: Annotated[bool, Var("1", "screw has torsional modes")] = False
    omega_1_hz: Annotated[float, Var("Hz", "first mode", min=0)] = 440.0
    zeta_1: Annotated[float, Var("1", "its damping ratio", min=0)] = 0.02
    r_1: Annotated[float, Var("rad/(V.s2)", "its residue")] = 0.0
    omega_2_hz: Annotated[float, Var("Hz", "second mode", min=0)] = 1100.0
    zeta_2: Annotated[float, Var("1", "its damping ratio", min=0)] = 0.02
    r_2: Annotated[float, Var("rad/(V.s2)", "its residue")] = 0.0


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
    current_loop: CurrentLoop = CurrentLoop()
    friction: Stribeck = Stribeck()
    pitch: Pitch = Pitch()
    torsion: Torsion = Torsion()


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ: the two masses, driven through the parts that are on."""
    torque: Any = np.where(p.current_loop.on, x.u_a, u.u)
    masses = ball_screw.derivative(
        ball_screw.State(x.x_1, x.x_2, x.v_1, x.v_2),
        Input(torque, u.d_1 - friction(x.v_1, p.friction), u.d_2),
        mechanics(p),
    )
    pitch = pitch_mode.derivative(
        pitch_mode.State(x.q, x.v_q),
        pitch_mode.Input(u.d_2),
        pitch_mode.Parameters(p.pitch.omega_hz, p.pitch.zeta, p.pitch.gamma),
    )
    t = p.torsion
    a_1 = acceleration(x.q_1, x.v_q1, t.r_1 * torque, t.omega_1_hz, t.zeta_1)
    a_2 = acceleration(x.q_2, x.v_q2, t.r_2 * torque, t.omega_2_hz, t.zeta_2)
    return State(
        *masses,
        lag(x.u_a, u.u, p.current_loop.omega_hz),
        *pitch,
        x.v_q1,
        a_1,
        x.v_q2,
        a_2,
    )


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return what the encoders see, and the table position in metres."""
    twist: Any = np.where(p.torsion.on, x.q_1 + x.q_2, 0.0)
    v_twist: Any = np.where(p.torsion.on, x.v_q1 + x.v_q2, 0.0)
    pitch: Any = np.where(p.pitch.on, x.q, 0.0)
    v_pitch: Any = np.where(p.pitch.on, x.v_q, 0.0)
    x_2 = x.x_2 + pitch
    return Output(x.x_1 + twist, x_2, x.v_1 + v_twist, x.v_2 + v_pitch, p.r_g * x_2)


def mechanics(p: Parameters) -> ball_screw.Parameters:
    """Return the parameters of the two masses alone."""
    return ball_screw.Parameters(p.m_1, p.m_2, p.b_1, p.b_2, p.k, p.c, p.m_12, p.r_g)


model = Continuous("BallScrewDrive", derivative, output, State(), Input(), Parameters())
