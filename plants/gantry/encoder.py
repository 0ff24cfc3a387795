"""Encoders of the gantry: table, left and right end, read in steps of q.

    x_m = q ⌊x/q + 1/2⌋

Source: Gordon 2010, sec. 4.2 (4 μm signal period) and 3.2.1 (10 nm after
interpolation on the same kind of scale; for the gantry our assumption).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants._quantiser import reading


class State(NamedTuple):
    """An encoder has no memory."""


class Input(NamedTuple):
    x: Annotated[float, Var("m", "table position")] = 0.0
    y_1: Annotated[float, Var("m", "left end")] = 0.0
    y_2: Annotated[float, Var("m", "right end")] = 0.0


class Output(NamedTuple):
    x_m: Annotated[float, Var("m", "reading of the table")]
    y_1m: Annotated[float, Var("m", "reading of the left end")]
    y_2m: Annotated[float, Var("m", "reading of the right end")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: exact readings")] = False
    q: Annotated[float, Var("m", "step", min=1e-15)] = 10e-9


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the three readings."""
    return x, Output(*(reading(position, p.q, p.on) for position in u))


model = Sampled(
    "GantryEncoder",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
