"""Feed-forward of the rigid drive: inertia and viscous friction.

    u_ff = (m_1 + m_2) a_r + (b_1 + b_2) v_r,    v_r = D x_r,   a_r = D D x_r

D is the backward difference over T_s.
Source: Gordon 2010, fig. 3.9 and sec. 3.3 (structure in words only).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.ball_screw._drive import Rigid
from fmus.model import Included, Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0
    dx_r: Annotated[float, Var("rad", "previous difference of the command")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0


class Output(NamedTuple):
    u_ff: Annotated[float, Var("V", "feed-forward")]


class Parameters(NamedTuple):
    drive: Annotated[Rigid, Included()] = Rigid()
    on: Annotated[bool, Var("1", "off: no feed-forward")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the feed-forward of this sample."""
    dx_r = u.x_r - x.x_r
    a_r = (dx_r - x.dx_r) / (T_s * T_s)
    m_1, m_2, b_1, b_2 = p.drive
    force = (m_1 + m_2) * a_r + (b_1 + b_2) * (dx_r / T_s)
    u_ff: Any = np.where(p.on, force, 0.0)
    return State(u.x_r, dx_r), Output(u_ff)


model = Sampled(
    "InertiaFeedforward",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
