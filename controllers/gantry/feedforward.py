"""Inertia feed-forward of the gantry.

    (u_ff1, u_ff2) = M_y (a_yr, a_yr)

Source: Gordon 2010, eq. 4.31; both ends take the unfiltered command's acceleration.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    """The feed-forward has no memory."""


class Input(NamedTuple):
    a_yr: Annotated[float, Var("m/s2", "commanded acceleration")] = 0.0
    m_11: Annotated[float, Var("V.s2/m", "mass matrix, left end", min=0)] = 0.0
    m_12: Annotated[float, Var("V.s2/m", "mass matrix, coupling")] = 0.0
    m_22: Annotated[float, Var("V.s2/m", "mass matrix, right end", min=0)] = 0.0


class Output(NamedTuple):
    u_ff1: Annotated[float, Var("V", "feed-forward of the left motor")]
    u_ff2: Annotated[float, Var("V", "feed-forward of the right motor")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: no feed-forward")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the feed-forward of this sample."""
    left: Any = np.where(p.on, (u.m_11 + u.m_12) * u.a_yr, 0.0)
    right: Any = np.where(p.on, (u.m_12 + u.m_22) * u.a_yr, 0.0)
    return x, Output(left, right)


model = Sampled(
    "GantryFeedforward",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
