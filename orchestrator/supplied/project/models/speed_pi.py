"""A PI speed controller that commands the current.

e = ω_r - ω,  i = K_p e + q,  q⁺ = q + T_s K_i e
Source: none; an example of a controller of your own.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    q: Annotated[float, Var("A", "integral part")] = 0.0


class Input(NamedTuple):
    omega_r: Annotated[float, Var("rad/s", "speed command")] = 0.0
    omega: Annotated[float, Var("rad/s", "measured speed")] = 0.0


class Output(NamedTuple):
    i: Annotated[float, Var("A", "current command")]
    e: Annotated[float, Var("rad/s", "speed error")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("A.s/rad", "proportional gain")] = 1.5
    K_i: Annotated[float, Var("A/rad", "integral gain")] = 100.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the next integral part, the current and the error."""
    e = u.omega_r - u.omega
    return State(x.q + T_s * p.K_i * e), Output(p.K_p * e + x.q, e)


model = Sampled(
    "SpeedPI", step, State(), Input(), Parameters(), period=Fraction(1, 4000)
)
