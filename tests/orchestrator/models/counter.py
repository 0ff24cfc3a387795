"""Counts its ticks and keeps what it reads, to see who runs when.

Source: none; a test of the master (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("1", "anything")] = 0.0


class Output(NamedTuple):
    k: Annotated[float, Var("1", "this tick")]
    rate: Annotated[float, Var("1/s", "this tick, as a rate")]
    t: Annotated[float, Var("s", "time of this tick")]
    seen: Annotated[float, Var("1", "input of this tick")]


class Parameters(NamedTuple):
    gain: Annotated[float, Var("1", "gain on the input")] = 1.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the tick and the input."""
    return State(x.k + 1), Output(x.k, x.k, x.k * T_s, p.gain * u.u)


model = Sampled(
    "Counter", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
