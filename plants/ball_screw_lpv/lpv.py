"""Identified LPV model: rigid body and a flexible mode that varies with the nut.

    u̇_0 = v,                  v̇ = (r_g² (f + f_c) - B_e v)/J_e
    q̇ = q_1 + b_0 f_c,        q̇_1 = -ω² q - 2ζω q_1 + f + b_1 f_c
    u_m = u_0 + α_11 q + β_11 q_1,      u_c = u_0 + α_12 q + β_12 q_1

ω, ζ, α, β follow the nut distance x_c, with run-out as a sine of the screw angle
(Table 3.3, m_wor = 0); f is the motor force less friction.  ``x_n`` = x_0 - u_c.
Source: Hanifzadegan 2014, eq. 3.20, 3.27, 3.35 in its minimal form of four states
(printed with eight, of which one more integrates).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw_lpv._drive import Amplifier, Friction
from plants.ball_screw_lpv._modal import State, motion, positions
from plants.ball_screw_lpv._mode import (
    Mode,
    OverPosition,
    Rigid,
    inertia,
    over_position,
)
from plants.ball_screw_lpv._ports import Input, Output


class Parameters(NamedTuple):
    rigid: Rigid = Rigid()
    amplifier: Amplifier = Amplifier()
    friction: Friction = Friction()
    mode: OverPosition = OverPosition()
    run_out: Annotated[bool, Var("1", "the mode varies with the screw angle too")] = (
        True
    )
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def mode_at(u: Input, p: Parameters) -> Mode:
    """Return the mode at the present nut distance."""
    return over_position(u.x_c, p.mode, p.rigid.r_g, p.run_out)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ; the workpiece counts as inertia only."""
    J_e = inertia(u.m_wor, p.rigid)
    return motion(x, u, mode_at(u, p), J_e, p.rigid, p.amplifier, p.friction)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions."""
    return positions(x, mode_at(u, p), p.x_0)


model = Continuous(
    "LPVBallScrew", derivative, output, State(), Input(), Parameters(), h_max=6e-5
)
