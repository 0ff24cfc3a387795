"""Noise of a position sensor: white, Gaussian, seeded.

    y = x + σ n(k, seed)

It stands before what quantises the reading; each sensor has a seed of its own.
Source: Maeda 2007, ch. 6 (the sensor's noise is seen in circles of 100 nm; its
value and its spectrum are not given); the generator in ``plants._noise``.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants._noise import P, normals


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    x: Annotated[float, Var("m", "position")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("m", "position with noise")]


class Parameters(NamedTuple):
    sigma: Annotated[float, Var("m", "standard deviation σ", min=0)] = 1e-9
    seed: Annotated[
        float, Var("1", "number of the sequence, whole", min=0, max=P - 1)
    ] = 1.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Add this tick's noise."""
    n, _ = normals(x.k, p.seed)
    return State(x.k + 1), Output(u.x + p.sigma * n)


model = Sampled(
    "SensorNoise",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
