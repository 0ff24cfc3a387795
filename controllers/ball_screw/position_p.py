"""Position loop of the P-PI cascade, closed on the linear encoder.

    v_c = K_px (x_r - y_2) + v_r,    v_r = D x_r = (x_r[k] - x_r[k-1]) / T_s

Without the velocity feed-forward v_r the drive lags by velocity over K_px.
Source: Gordon 2010, fig. 3.9, eq. 3.25; the gain is not published (set A).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    x_r: Annotated[float, Var("rad", "previous command")] = 0.0


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    y_2: Annotated[float, Var("rad", "linear encoder as screw angle")] = 0.0


class Output(NamedTuple):
    v_c: Annotated[float, Var("rad/s", "velocity command")]


class Parameters(NamedTuple):
    K_px: Annotated[float, Var("1/s", "position gain")] = 189.0
    velocity_feedforward: Annotated[bool, Var("1", "add v_r to the command")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the velocity command of this sample."""
    v_r: Any = np.where(p.velocity_feedforward, (u.x_r - x.x_r) / T_s, 0.0)
    return State(u.x_r), Output(p.K_px * (u.x_r - u.y_2) + v_r)


model = Sampled(
    "PositionP",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
