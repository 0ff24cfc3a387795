"""Circular contour of two axes: one follows a sine, the other a cosine.

    x_r = R sin 2πf(t - t_0),   y_r = R cos 2πf(t - t_0)

Before t_0 both rest on the first point, (0, R).  A circle run from rest to rest:
``controllers.references.circle_path``.
Source: Maeda 2007, sec. 6.3.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.references import sine as sine_reference
from controllers.references.sine import Input, State
from fmus.model import Sampled, Var


class Output(NamedTuple):
    x_r: Annotated[float, Var("m", "reference of the first axis")]
    v_xr: Annotated[float, Var("m/s", "its velocity")]
    y_r: Annotated[float, Var("m", "reference of the second axis")]
    v_yr: Annotated[float, Var("m/s", "its velocity")]


class Parameters(NamedTuple):
    R: Annotated[float, Var("m", "radius")] = 5e-3
    frequency_hz: Annotated[float, Var("Hz", "revolutions per second", min=0)] = 0.5
    t_0: Annotated[float, Var("s", "rest before the circle", min=0)] = 0.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the references of this sample."""
    sine = sine_reference.Parameters(p.R, p.frequency_hz, 0.0, p.t_0)
    cosine = sine._replace(phase=np.pi / 2)
    x_next, first = sine_reference.step(x, u, sine, T_s)
    _, second = sine_reference.step(x, u, cosine, T_s)
    return x_next, Output(*first, *second)


model = Sampled(
    "CircleReference",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
