"""PI compensator that brings the motion onto the nominal characteristic trajectory.

    u = K_p u_p + u_i,    u_i⁺ = u_i + K_i T_s u_p

The current sample counts in the integral, which is frozen in saturation.
Source: Maeda 2007, fig. 3-9, eq. 3-16; gains of controller 1, table 5-1.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.leadscrew._frozen_integral import integrated
from fmus.model import Sampled, Var


class State(NamedTuple):
    u_i: Annotated[float, Var("A", "integral")] = 0.0


class Input(NamedTuple):
    u_p: Annotated[float, Var("mm/s", "distance from the trajectory")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("A.s/mm", "proportional gain")] = 0.981
    K_i: Annotated[float, Var("A/mm", "integral gain")] = 156.9
    u_s: Annotated[float, Var("A", "where the actuator saturates", min=0)] = 6.0
    anti_windup: Annotated[bool, Var("1", "freeze the integral")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the integral and the current command."""
    u_o = p.K_p * u.u_p
    u_i = integrated(x.u_i, p.K_i * u.u_p, u_o, p.u_s, p.anti_windup, T_s)
    return State(u_i), Output(u_o + u_i)


model = Sampled(
    "NCTCompensator",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
