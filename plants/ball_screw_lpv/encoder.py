"""Measured positions: a linear encoder of 100 nm on the table.

    y_c = q ⌊u_c/q + 1/2⌋,     y_m = u_m,     x_c = x_0 - y_c

The rotary encoder's step is not published: it reads exactly.
Source: Hanifzadegan 2014, sec. 4.4 (100 nm), 4.5.2 (x_c = 650 mm - r).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var
from plants._quantiser import reading


class State(NamedTuple):
    """An encoder has no memory."""


class Input(NamedTuple):
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0


class Output(NamedTuple):
    y_m: Annotated[float, Var("m", "rotary encoder as table travel")]
    y_c: Annotated[float, Var("m", "linear encoder")]
    x_c: Annotated[float, Var("m", "nut distance from the thrust bearing")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: exact readings")] = True
    q: Annotated[float, Var("m", "step of the linear encoder", min=1e-12)] = 100e-9
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return both readings."""
    y_c = reading(u.u_c, p.q, p.on)
    return x, Output(u.u_m, y_c, p.x_0 - y_c)


model = Sampled(
    "LinearEncoder", step, State(), Input(), Parameters(), period=Fraction(9, 25_000)
)
