"""Encoders of the drive: both axes read in steps of q of table motion.

    y = q ⌊x/q + 1/2⌋

Source: Gordon 2010, sec. 3.2.1 (10 nm of table motion on either encoder).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from plants._quantiser import reading


class State(NamedTuple):
    """An encoder has no memory."""


class Input(NamedTuple):
    x_1: Annotated[float, Var("rad", "screw angle")] = 0.0
    x_2: Annotated[float, Var("rad", "table position as screw angle")] = 0.0


class Output(NamedTuple):
    y_1: Annotated[float, Var("rad", "rotary encoder")]
    y_2: Annotated[float, Var("rad", "linear encoder as screw angle")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "off: exact readings")] = False
    q: Annotated[float, Var("m", "step in table motion", min=1e-15)] = 10e-9
    r_g: Annotated[float, Var("m/rad", "table motion per screw angle", min=1e-12)] = (
        0.020 / (2 * np.pi)
    )


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return both readings."""
    q = p.q / p.r_g
    return x, Output(reading(u.x_1, q, p.on), reading(u.x_2, q, p.on))


model = Sampled(
    "Encoder",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
