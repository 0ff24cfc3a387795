"""Run-out of the screw as a disturbance: a force once per revolution.

    f = F sin(x_c/r_g + φ)

The bearings' misalignment also varies the mode (``run_out`` of ``lpv``).
Source: Hanifzadegan 2014, sec. 3.5.1 (as variation of parameters); as a force it is
not identified there, F is our choice.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from plants.ball_screw_lpv._mode import R_G


class State(NamedTuple):
    """A force without memory."""


class Input(NamedTuple):
    x_c: Annotated[float, Var("m", "nut distance from the thrust bearing", min=0)] = 0.4


class Output(NamedTuple):
    f: Annotated[float, Var("N", "disturbance on the table")]


class Parameters(NamedTuple):
    F: Annotated[float, Var("N", "amplitude")] = 20.0
    phase: Annotated[float, Var("rad", "phase at the bearing")] = 0.0
    r_g: Annotated[float, Var("m/rad", "table travel per screw angle", min=1e-9)] = R_G


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the force at this position."""
    return x, Output(p.F * np.sin(u.x_c / p.r_g + p.phase))


model = Sampled(
    "RunOut", step, State(), Input(), Parameters(), period=Fraction(3, 50_000)
)
