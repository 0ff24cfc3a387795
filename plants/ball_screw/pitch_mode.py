"""Pitch of the table: a mode that disturbances excite and the motor cannot.

    q̈ + 2ζω q̇ + ω² q = γ ω² d_2

The linear encoder reads x_2 + q.
Source: Gordon 2010, sec. 3.2.1, 3.4 (43 Hz); ζ and γ are our choice.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var
from plants._modes import acceleration


class State(NamedTuple):
    q: Annotated[float, Var("rad", "pitch at the encoder as screw angle")] = 0.0
    v_q: Annotated[float, Var("rad/s", "its rate")] = 0.0


class Input(NamedTuple):
    d_2: Annotated[float, Var("V", "disturbance on the table")] = 0.0


class Output(NamedTuple):
    q: Annotated[float, Var("rad", "pitch at the encoder as screw angle")]
    v_q: Annotated[float, Var("rad/s", "its rate")]


class Parameters(NamedTuple):
    omega_hz: Annotated[float, Var("Hz", "natural frequency", min=0)] = 43.0
    zeta: Annotated[float, Var("1", "damping ratio", min=0)] = 0.02
    gamma: Annotated[float, Var("rad/V", "static compliance")] = 1e-3


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the rates of the mode."""
    force: Any = p.gamma * (2 * np.pi * p.omega_hz) ** 2 * u.d_2
    return State(x.v_q, acceleration(x.q, x.v_q, force, p.omega_hz, p.zeta))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the pitch and its rate."""
    return Output(x.q, x.v_q)


model = Continuous("PitchMode", derivative, output, State(), Input(), Parameters())
