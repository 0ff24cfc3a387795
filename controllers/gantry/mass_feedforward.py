"""Inertia feed-forward of a linear axis.

    u_ff = m_x a_xr

Source: Gordon 2010, eq. 4.19.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    """The feed-forward has no memory."""


class Input(NamedTuple):
    a_xr: Annotated[float, Var("m/s2", "commanded acceleration")] = 0.0


class Output(NamedTuple):
    u_ff: Annotated[float, Var("V", "feed-forward")]


class Parameters(NamedTuple):
    m_x: Annotated[float, Var("V.s2/m", "mass", min=0)] = 0.6977
    on: Annotated[bool, Var("1", "off: no feed-forward")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the feed-forward of this sample."""
    u_ff: Any = np.where(p.on, p.m_x * u.a_xr, 0.0)
    return x, Output(u_ff)


model = Sampled(
    "MassFeedforward",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
