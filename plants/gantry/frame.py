"""T-type gantry on two linear motors: centre of mass and yaw, table anywhere on it.

    m ÿ_c = u_1 + u_2 + d_t
    J θ̈ + c θ̇ + k θ = -a_1 u_1 + a_2 u_2 + b_t d_t
    y_1 = y_c - a_1 θ,    y_2 = y_c + a_2 θ

The table at x from mid-span, towards motor 2, moves the centre of mass, the
inertia and the lever b_t of a force at the table:

    J = J_0 + (m_x + m_p) (d + x)²,    b_t = L/2 + x - a_1
    a_1 = L/2 - d (1 - m_x/m) + m_x x/m + L α_0          (m_p = 0)

The states are those of the ends: they stay right while x moves; y_c and θ would
jump with a_1.  Forces from x moving (Coriolis, Ṁ) are left out, as in the source.
The payload m_p and the offset α_0 are ours; with α_0 = 0, x = 0 is mid-span and
d + x the distance of the table from the centre of mass of the rest.
Source: Gordon 2010, eq. 4.1 to 4.4, 4.16, 4.22.
"""

from typing import Annotated, Any, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    y_1: Annotated[float, Var("m", "left end", nominal=1e-6)] = 0.0
    y_2: Annotated[float, Var("m", "right end", nominal=1e-6)] = 0.0
    v_1: Annotated[float, Var("m/s", "velocity of the left end", nominal=1e-3)] = 0.0
    v_2: Annotated[float, Var("m/s", "velocity of the right end", nominal=1e-3)] = 0.0


class Input(NamedTuple):
    u_1: Annotated[float, Var("V", "control signal of the left motor")] = 0.0
    u_2: Annotated[float, Var("V", "control signal of the right motor")] = 0.0
    d_t: Annotated[float, Var("V", "disturbance at the table")] = 0.0
    x: Annotated[float, Var("m", "table position along the gantry")] = 0.0


class Output(NamedTuple):
    y_1: Annotated[float, Var("m", "left end")]
    y_2: Annotated[float, Var("m", "right end")]
    v_1: Annotated[float, Var("m/s", "velocity of the left end")]
    v_2: Annotated[float, Var("m/s", "velocity of the right end")]
    y_t: Annotated[float, Var("m", "position at the table")]
    theta: Annotated[float, Var("rad", "yaw angle")]


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


class Geometry(NamedTuple):
    """Mass, inertia and levers with the table at one place."""

    m: Any
    J: Any
    a_1: Any
    a_2: Any
    b_t: Any


def geometry(x: Any, p: Parameters) -> Geometry:
    """Return the inertial properties with the table at x (m) (eq. 4.16, 4.22)."""
    share = p.m_x / p.m
    alone = p.L / 2 - p.d * (1 - share) + share * x + p.L * p.alpha_0
    m = p.m + p.m_p
    a_1 = (p.m * alone + p.m_p * (p.L / 2 + x)) / m
    lever = p.d + x
    J = p.J_0 + (p.m_x + p.m_p) * lever * lever
    return Geometry(m, J, a_1, p.L - a_1, p.L / 2 + x - a_1)


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ (eq. 4.1, 4.2)."""
    g = geometry(u.x, p)
    theta, omega = (x.y_2 - x.y_1) / p.L, (x.v_2 - x.v_1) / p.L
    torque = -g.a_1 * u.u_1 + g.a_2 * u.u_2 + g.b_t * u.d_t
    yaw = (torque - p.c * omega - p.k * theta) / g.J
    push = (u.u_1 + u.u_2 + u.d_t) / g.m
    return State(x.v_1, x.v_2, push - g.a_1 * yaw, push + g.a_2 * yaw)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the ends, and where the gantry is at the table."""
    theta = (x.y_2 - x.y_1) / p.L
    y_t = x.y_1 + (p.L / 2 + u.x) * theta
    return Output(x.y_1, x.y_2, x.v_1, x.v_2, y_t, theta)


model = Continuous("Gantry", derivative, output, State(), Input(), Parameters())
