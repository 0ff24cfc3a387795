"""Gain schedule of the gantry: mass matrix and its distribution, by the x position.

    J = J_0 + m_x (d + x)²,    a_1 = L/2 - d (1 - m_x/m) + m_x x/m + L α_0
    α_1 = a_2/L,  α_2 = a_1/L,    a_2 = L - a_1
    M_y = [a_2² m + J, a_1 a_2 m - J; a_1 a_2 m - J, a_1² m + J] / L²

The estimates of the controller; what the plant really is belongs to the plant.
Source: Gordon 2010, eq. 4.3, 4.16, 4.22, 4.33.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    """The schedule has no memory."""


class Input(NamedTuple):
    x_s: Annotated[float, Var("m", "scheduling position, the x command")] = 0.0


class Output(NamedTuple):
    alpha_1: Annotated[float, Var("1", "share of the mass at the left end")]
    alpha_2: Annotated[float, Var("1", "share of the mass at the right end")]
    m_11: Annotated[float, Var("V.s2/m", "mass matrix, left end")]
    m_12: Annotated[float, Var("V.s2/m", "mass matrix, coupling")]
    m_22: Annotated[float, Var("V.s2/m", "mass matrix, right end")]


class Parameters(NamedTuple):
    m: Annotated[float, Var("V.s2/m", "mass of gantry and table", min=1e-9)] = 2.722
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=0)] = 0.6977
    L: Annotated[float, Var("m", "distance of the motors", min=1e-9)] = 1.484
    J_0: Annotated[float, Var("V.m.s2/rad", "inertia without table", min=0)] = 0.4342
    d: Annotated[float, Var("m", "table's lever at x = 0")] = 0.1655
    alpha_0: Annotated[float, Var("1", "offset of the mass distribution")] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the schedule at the position x_s."""
    share = p.m_x / p.m
    a_1 = p.L / 2 - p.d * (1 - share) + share * u.x_s + p.L * p.alpha_0
    a_2 = p.L - a_1
    lever = p.d + u.x_s
    J = p.J_0 + p.m_x * lever * lever
    square = p.L * p.L
    return x, Output(
        a_2 / p.L,
        a_1 / p.L,
        (a_2 * a_2 * p.m + J) / square,
        (a_1 * a_2 * p.m - J) / square,
        (a_1 * a_1 * p.m + J) / square,
    )


model = Sampled(
    "GantrySchedule",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
