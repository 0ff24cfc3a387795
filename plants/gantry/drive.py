"""The gantry with what its two-degree-of-freedom model leaves out.

Each part has a switch; with all of them off this is ``plants.gantry.frame``.

    ḟ_i = ω_l (u_i - f_i)                              amplifiers and motors
    f_i + A_r sin(2π y_i/λ_r + φ_r)                    force ripple
    m_q (q̈ + 2ζω q̇ + ω² q) = φ_1 f_1 + φ_2 f_2 + φ_t d_t        per mode
    y_i + Σ φ_i q                                      seen by the encoders

The modes are compliances besides the yaw: of the machine base against the
encoders, an unexplained one at 320 Hz and bending of the beam at 382 Hz.
Source: Gordon 2010, sec. 4.3.3, 4.4.2 (23, 36, 320, 382 Hz); shapes, modal masses
and damping are not published and our choice.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants._modes import acceleration, lag
from plants.gantry import frame as gantry
from plants.gantry._motor import Amplifier, Ripple, ripple
from plants.gantry.frame import Input, Output


class State(NamedTuple):
    y_1: Annotated[float, Var("m", "left end of the rigid gantry", nominal=1e-6)] = 0.0
    y_2: Annotated[float, Var("m", "right end of the rigid gantry", nominal=1e-6)] = 0.0
    v_1: Annotated[float, Var("m/s", "velocity of the left end", nominal=1e-3)] = 0.0
    v_2: Annotated[float, Var("m/s", "velocity of the right end", nominal=1e-3)] = 0.0
    f_1: Annotated[float, Var("V", "force of the left motor")] = 0.0
    f_2: Annotated[float, Var("V", "force of the right motor")] = 0.0
    q_b: Annotated[float, Var("m", "deflection of the base", nominal=1e-6)] = 0.0
    v_b: Annotated[float, Var("m/s", "its rate", nominal=1e-3)] = 0.0
    q_u: Annotated[
        float, Var("m", "deflection of the unexplained mode", nominal=1e-6)
    ] = 0.0
    v_u: Annotated[float, Var("m/s", "its rate", nominal=1e-3)] = 0.0
    q_t: Annotated[float, Var("m", "bending of the beam", nominal=1e-6)] = 0.0
    v_t: Annotated[float, Var("m/s", "its rate", nominal=1e-4)] = 0.0


class Mode(NamedTuple):
    on: Annotated[bool, Var("1", "mode is seen")] = False
    omega_hz: Annotated[float, Var("Hz", "natural frequency", min=0)] = 36.0
    zeta: Annotated[float, Var("1", "damping ratio", min=0)] = 0.03
    m_q: Annotated[float, Var("V.s2/m", "modal mass", min=1e-12)] = 13.61
    phi_1: Annotated[float, Var("1", "share of the left end")] = 1.0
    phi_2: Annotated[float, Var("1", "share of the right end")] = 1.0
    phi_t: Annotated[float, Var("1", "share of the table")] = 1.0


class Parameters(NamedTuple):
    m: Annotated[float, Var("V.s2/m", "mass of gantry and table", min=1e-9)] = 2.722
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=0)] = 0.6977
    m_p: Annotated[float, Var("V.s2/m", "payload on the table", min=0)] = 0.0
    L: Annotated[float, Var("m", "distance of the motors", min=1e-9)] = 1.484
    J_0: Annotated[float, Var("V.m.s2/rad", "inertia without table", min=1e-9)] = 0.4342
    d: Annotated[float, Var("m", "table's lever at x = 0")] = 0.1655
    c: Annotated[float, Var("V.m.s/rad", "damping of the yaw", min=0)] = 18.17
    k: Annotated[float, Var("V.m/rad", "stiffness of the yaw", min=0)] = 159200.0
    alpha_0: Annotated[float, Var("1", "offset of the mass distribution")] = 0.0
    amplifier: Amplifier = Amplifier()
    ripple_1: Ripple = Ripple()
    ripple_2: Ripple = Ripple()
    base: Mode = Mode()
    unexplained: Mode = Mode(False, 320.0, 0.02, 50.0, 1.0, -1.0, 0.0)
    bending: Mode = Mode(False, 382.0, 0.02, 50.0, 1.0, 1.0, -0.5)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ: the rigid gantry, driven through the parts that are on."""
    f_1: Any = np.where(p.amplifier.on, x.f_1, u.u_1) + ripple(x.y_1, p.ripple_1)
    f_2: Any = np.where(p.amplifier.on, x.f_2, u.u_2) + ripple(x.y_2, p.ripple_2)
    driven = Input(f_1, f_2, u.d_t, u.x)
    rigid = gantry.State(x.y_1, x.y_2, x.v_1, x.v_2)
    return State(
        *gantry.derivative(rigid, driven, mechanics(p)),
        lag(x.f_1, u.u_1, p.amplifier.omega_l_hz),
        lag(x.f_2, u.u_2, p.amplifier.omega_l_hz),
        *deflection(x.q_b, x.v_b, driven, p.base),
        *deflection(x.q_u, x.v_u, driven, p.unexplained),
        *deflection(x.q_t, x.v_t, driven, p.bending),
    )


def deflection(q: Any, v: Any, f: Input, p: Mode) -> tuple[Any, Any]:
    """Return q̇ and q̈ of a mode under the forces f."""
    force = p.phi_1 * f.u_1 + p.phi_2 * f.u_2 + p.phi_t * f.d_t
    return v, acceleration(q, v, force / p.m_q, p.omega_hz, p.zeta)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return what the encoders and an interferometer at the table see."""
    rigid = gantry.State(x.y_1, x.y_2, x.v_1, x.v_2)
    y = gantry.output(rigid, u, mechanics(p))
    modes = (
        (p.base, x.q_b, x.v_b),
        (p.unexplained, x.q_u, x.v_u),
        (p.bending, x.q_t, x.v_t),
    )
    y_1, y_2, v_1, v_2, y_t = y.y_1, y.y_2, y.v_1, y.v_2, y.y_t
    for mode, q, v in modes:
        seen: Any = np.where(mode.on, q, 0.0)
        rate: Any = np.where(mode.on, v, 0.0)
        y_1, v_1 = y_1 + mode.phi_1 * seen, v_1 + mode.phi_1 * rate
        y_2, v_2 = y_2 + mode.phi_2 * seen, v_2 + mode.phi_2 * rate
        y_t = y_t + mode.phi_t * seen
    return Output(y_1, y_2, v_1, v_2, y_t, (y_2 - y_1) / p.L)


def mechanics(p: Parameters) -> gantry.Parameters:
    """Return the parameters of the rigid gantry alone."""
    return gantry.Parameters(p.m, p.m_x, p.m_p, p.L, p.J_0, p.d, p.c, p.k, p.alpha_0)


model = Continuous("GantryDrive", derivative, output, State(), Input(), Parameters())
