"""Encoders of the drive with interpolation error and noise, then in steps of q.

    y_i = q ⌊(x_i + A_i sin(2πx_i/λ) + σ_i n_i)/q + 1/2⌋

Lengths are table motion, positions screw angles.  With A = σ = 0 this is
``plants.ball_screw.encoder``; the two noises belong to one seed.
Source: Gordon 2010, sec. 3.2.1 (4 μm periods, 10 nm steps; rated 200 nm on the
screw, 40 nm on the table, read as amplitudes within a period); noise is ours.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Included, Sampled, Var
from plants._noise import normals
from plants._quantiser import reading
from plants._scale import Scale, Sequence, seen
from plants.ball_screw.encoder import Input, Output


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: readings are not in steps")] = True
    q: Annotated[float, Var("m", "step in table motion", min=1e-15)] = 10e-9
    r_g: Annotated[float, Var("m/rad", "table motion per screw angle", min=1e-12)] = (
        0.020 / (2 * np.pi)
    )
    noise: Annotated[Sequence, Included()] = Sequence()
    rotary: Scale = Scale(200e-9, 4e-6, 0.0)
    linear: Scale = Scale(40e-9, 4e-6, 0.0)


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return both readings."""
    n_1, n_2 = normals(x.k, p.noise.seed)
    q = p.q / p.r_g
    y_1 = reading(seen(u.x_1, n_1, p.rotary, p.r_g), q, p.on)
    y_2 = reading(seen(u.x_2, n_2, p.linear, p.r_g), q, p.on)
    return State(x.k + 1), Output(y_1, y_2)


model = Sampled(
    "Scales", step, State(), Input(), Parameters(), period=Fraction(1, 20_000)
)
