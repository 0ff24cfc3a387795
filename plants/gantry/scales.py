"""Encoders of the gantry with interpolation error and noise, then in steps of q.

    x_m = q ⌊(x + A sin(2πx/λ) + σ n)/q + 1/2⌋

The same scale on all three axes, each with a noise of its own out of one seed.
With A = σ = 0 this is ``plants.gantry.encoder``.
Source: Gordon 2010, sec. 4.2 (4 μm signal period) and 3.2.1 (10 nm, 40 nm rated, on
the same kind of scale; for the gantry our assumption); noise is ours.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Included, Sampled, Var
from plants._noise import normals
from plants._quantiser import reading
from plants._scale import Scale, Sequence, seen
from plants.gantry.encoder import Input, Output


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: readings are not in steps")] = True
    q: Annotated[float, Var("m", "step", min=1e-15)] = 10e-9
    noise: Annotated[Sequence, Included()] = Sequence()
    scale: Annotated[Scale, Included()] = Scale(40e-9, 4e-6, 0.0)


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the three readings; a tick takes two numbers of the sequence."""
    n_x, n_1 = normals(2 * x.k, p.noise.seed)
    n_2, _ = normals(2 * x.k + 1, p.noise.seed)
    x_m = reading(seen(u.x, n_x, p.scale), p.q, p.on)
    y_1 = reading(seen(u.y_1, n_1, p.scale), p.q, p.on)
    y_2 = reading(seen(u.y_2, n_2, p.scale), p.q, p.on)
    return State(x.k + 1), Output(x_m, y_1, y_2)


model = Sampled(
    "GantryScales", step, State(), Input(), Parameters(), period=Fraction(1, 15_000)
)
