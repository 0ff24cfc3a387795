"""Identified LPV model whose flexible mode varies with nut and workpiece.

    u̇_0 = v,                  v̇ = (r_g² (f + f_c) - B_e v)/J_e(m_wor)
    q̇ = q_1 + b_0 f_c,        q̇_1 = -ω² q - 2ζω q_1 + f + b_1 f_c
    u_m = u_0 + α_11 q + β_11 q_1,      u_c = u_0 + α_12 q + β_12 q_1

ω, α, β are affine in the nut distance x_c and the workpiece mass m_wor (Table 3.4,
repaired); J_e = J_e0 + r_g² m_wor.  ``x_n`` = x_0 - u_c.
Source: Hanifzadegan 2014, sec. 3.5.2 and 3.6, eq. 3.3, 3.35, Table 3.4.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv._drive import Amplifier, Friction
from plants.ball_screw_lpv._modal import State, motion, positions
from plants.ball_screw_lpv._mode import (
    Mode,
    OverPositionAndMass,
    Rigid,
    inertia,
    over_position_and_mass,
)
from plants.ball_screw_lpv._ports import Input, Output


class Parameters(NamedTuple):
    rigid: Rigid = Rigid()
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction()
    mode: OverPositionAndMass = OverPositionAndMass()
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def mode_at(u: Input, p: Parameters) -> Mode:
    """Return the mode at the present nut distance and mass."""
    return over_position_and_mass(u.x_c, u.m_wor, p.mode)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    J_e = inertia(u.m_wor, p.rigid)
    return motion(x, u, mode_at(u, p), J_e, p.rigid, p.amplifier, p.friction)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions."""
    return positions(x, mode_at(u, p), p.x_0)


model = Continuous(
    "LPVBallScrewMass", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
