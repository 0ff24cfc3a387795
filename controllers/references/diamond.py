"""Square contour of two axes with its diagonals along them: |x| + |y| = D.

Each side is run at the path speed v; the axes follow triangle waves of slope
v/√2 and period 4√2 D/v, a quarter of it apart.  Before t_0 both rest on the
first corner, (0, D).  A path with stops in the corners: ``diamond_path``.
Source: Maeda 2007, sec. 6.3.3; D is half the diagonal.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.references.circle import Output
from controllers.references.sine import Input, State
from fmus.model import Sampled, Var
from fmus.ticks import tick_of, turn


class Parameters(NamedTuple):
    D: Annotated[float, Var("m", "half the diagonal", min=1e-12)] = 5e-3
    v: Annotated[float, Var("m/s", "speed along the path", min=0)] = 31.416e-3
    t_0: Annotated[float, Var("s", "rest before the square", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the references of this sample."""
    k = x.k - tick_of(p.t_0, T_s)
    around = turn(p.v / (4 * np.sqrt(2) * p.D), np.maximum(k, 0), T_s)
    slope = np.where(k >= 0, p.v / np.sqrt(2), 0.0)
    x_r, way_x = triangle(around)
    y_r, way_y = triangle(around + 0.25)
    return State(x.k + 1), Output(p.D * x_r, way_x * slope, p.D * y_r, way_y * slope)


def triangle(turns: Any) -> tuple[Any, Any]:
    """Return a triangle wave of height 1 that starts upward at 0, and its sign."""
    part = turns + 0.25 - np.floor(turns + 0.25)
    return 1 - np.abs(4 * part - 2), np.where(part < 0.5, 1.0, -1.0)


model = Sampled(
    "DiamondReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
