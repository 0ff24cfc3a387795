"""Noise of an amplifier: white, Gaussian, seeded, as an input voltage.

    d = σ n(k, seed)

Source: Gordon 2010, sec. 3.2.1 (amplifiers in current mode; their noise is not
given); the generator in ``plants._noise``.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants._noise import P, normals


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The source follows the clock alone."""


class Output(NamedTuple):
    d: Annotated[float, Var("V", "noise at the amplifier's input")]


class Parameters(NamedTuple):
    sigma: Annotated[float, Var("V", "standard deviation σ", min=0)] = 1e-3
    seed: Annotated[
        float, Var("1", "number of the sequence, whole", min=0, max=P - 1)
    ] = 1.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return this tick's noise."""
    n, _ = normals(x.k, p.seed)
    return State(x.k + 1), Output(p.sigma * n)


model = Sampled(
    "AmplifierNoise", step, State(), Input(), Parameters(), period=Fraction(1, 20_000)
)
