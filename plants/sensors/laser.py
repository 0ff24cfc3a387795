"""Laser position sensor of one axis: reads in steps of q.

    y = q ⌊x/q + 1/2⌋

Source: Maeda 2007, ch. 2 (Agilent 10897B, 1.24 nm).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants._quantiser import reading


class State(NamedTuple):
    """The sensor has no memory."""


class Input(NamedTuple):
    x: Annotated[float, Var("m", "table position")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("m", "measured position")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: exact readings")] = True
    q: Annotated[float, Var("m", "step of the reading", min=1e-15)] = 1.24e-9


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the reading."""
    return x, Output(reading(u.x, p.q, p.on))


model = Sampled(
    "LaserSensor",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
