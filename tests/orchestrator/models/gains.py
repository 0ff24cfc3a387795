"""One gain of a table and one offset, read where they are used.

Source: none; a test of how values are laid over one another (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import FloatArray, Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks so far")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("m", "input")] = 0.0
    on: Annotated[bool, Var("1", "whether the input passes")] = True


class Output(NamedTuple):
    y: Annotated[float, Var("m", "input and offset")]
    K_12: Annotated[float, Var("1", "second gain of the first row")]
    K_21: Annotated[float, Var("1", "first gain of the second row")]


class Parameters(NamedTuple):
    K: Annotated[FloatArray, Var("1", "gains")] = np.array(
        [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    )
    v: Annotated[FloatArray, Var("m", "offsets")] = np.array([1.0, 2.0])
    k: Annotated[float, Var("N/m", "stiffness")] = 2.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the input with its offset, and two of the gains."""
    passed = u.on * u.u
    return State(x.k + 1), Output(p.K[0, 0] * passed + p.v[0], p.K[0, 1], p.K[1, 0])


model = Sampled("Gains", step, State(), Input(), Parameters(), Fraction(1, 1000))
