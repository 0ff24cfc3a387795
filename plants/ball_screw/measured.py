"""The ball-screw drive as the source measured it: what ``drive`` still leaves out.

    ü_a + 2ζω u̇_a + ω² u_a = ω² u                     current loop of second order
    y_2 = x_2 + Σ ρ_i q_i                             torsional modes at the table
    δ = x_2 - x_1 - e(x_1),   e = A/r_g sin(x_1 + φ)   lead error, once per turn
    f = k (δ - sat(δ, b/2r_g)) + c δ̇                  lost motion b of the nut
    m_1 ẍ_1 = ... + (1 + e′) f,   m_2 ẍ_2 = ... - f    no power is lost in the nut

``ρ_i`` is mode i at the table over that at the screw: its residue there is ρ_i r_i.
Each part has a switch; with all of them off this is ``plants.ball_screw.drive``.
Source: Gordon 2010, sec. 3.2.1 (450 Hz; 440, 1100 Hz), 3.4 and ch. 5 (lead error is
named); orders, residues, shapes, lead error and lost motion are not printed.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Included, Var
from plants._modes import acceleration
from plants.ball_screw import drive as ball_screw_drive
from plants.ball_screw import two_mass as ball_screw
from plants.ball_screw.two_mass import Input, Output


class State(NamedTuple):
    drive: Annotated[ball_screw_drive.State, Included()] = ball_screw_drive.State()
    v_a: Annotated[float, Var("V/s", "rate of the torque", nominal=1e3)] = 0.0


class SecondOrder(NamedTuple):
    on: Annotated[bool, Var("1", "the current loop is of second order")] = False
    zeta: Annotated[float, Var("1", "its damping ratio", min=0)] = 0.4


class Shapes(NamedTuple):
    rho_1: Annotated[float, Var("1", "first torsional mode, table over screw")] = 0.0
    rho_2: Annotated[float, Var("1", "second torsional mode, table over screw")] = 0.0


class LeadError(NamedTuple):
    on: Annotated[bool, Var("1", "the screw has a periodic lead error")] = False
    A: Annotated[float, Var("m", "amplitude in table motion", min=0)] = 1e-6
    phi: Annotated[float, Var("rad", "phase at zero")] = 0.0


class LostMotion(NamedTuple):
    on: Annotated[bool, Var("1", "the nut has lost motion")] = False
    b: Annotated[float, Var("m", "gap in table motion", min=0)] = 0.2e-6


class Parameters(NamedTuple):
    drive: Annotated[ball_screw_drive.Parameters, Included()] = (
        ball_screw_drive.Parameters()
    )
    second_order: SecondOrder = SecondOrder()
    shapes: Shapes = Shapes()
    lead_error: LeadError = LeadError()
    lost_motion: LostMotion = LostMotion()


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ: the drive, with the nut's force and the loop's order put right."""
    rates = ball_screw_drive.derivative(x.drive, u, p.drive)
    more = ball_screw.derivative(
        ball_screw.State(), added_force(x, p), ball_screw_drive.mechanics(p.drive)
    )
    omega_hz = p.drive.current_loop.omega_hz
    omega = 2 * np.pi * omega_hz
    a = acceleration(x.drive.u_a, x.v_a, omega**2 * u.u, omega_hz, p.second_order.zeta)
    second = p.second_order.on
    rate: Any = np.where(second, x.v_a, rates.u_a)
    curvature: Any = np.where(second, a, 0.0)
    v_1, v_2 = rates.v_1 + more.v_1, rates.v_2 + more.v_2
    return State(rates._replace(v_1=v_1, v_2=v_2, u_a=rate), curvature)


def added_force(x: State, p: Parameters) -> Input:
    """Return what lead error and lost motion add to the nut's force (V)."""
    s = x.drive
    A: Any = np.where(p.lead_error.on, p.lead_error.A / p.drive.r_g, 0.0)
    angle = s.x_1 + p.lead_error.phi
    slope = A * np.cos(angle)
    half = p.lost_motion.b / (2 * p.drive.r_g)
    wound = s.x_2 - s.x_1 - A * np.sin(angle)
    held = np.minimum(np.maximum(wound, -half), half)
    free: Any = np.where(p.lost_motion.on, held, 0.0)
    f = p.drive.k * (wound - free) + p.drive.c * (s.v_2 - s.v_1 - slope * s.v_1)
    linear = p.drive.k * (s.x_2 - s.x_1) + p.drive.c * (s.v_2 - s.v_1)
    return Input(0.0, f - linear + slope * f, linear - f)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return what the encoders see, and the table position in metres."""
    y = ball_screw_drive.output(x.drive, u, p.drive)
    s, shapes, on = x.drive, p.shapes, p.drive.torsion.on
    twist: Any = np.where(on, shapes.rho_1 * s.q_1 + shapes.rho_2 * s.q_2, 0.0)
    rate: Any = np.where(on, shapes.rho_1 * s.v_q1 + shapes.rho_2 * s.v_q2, 0.0)
    x_2 = y.x_2 + twist
    return Output(y.x_1, x_2, y.v_1, y.v_2 + rate, p.drive.r_g * x_2)


model = Continuous(
    "BallScrewMeasured", derivative, output, State(), Input(), Parameters()
)
