"""Tracking controller K_track: one linear law, synthesised by H∞.

    x⁺ = A x + B e,   v_t = C x + D e,   e = r - u_c

Sampled by Tustin's rule in the design, whose matrices hold for its period alone.
Source: Hanifzadegan 2014, sec. 4.3.1 and 4.4.1, Table 4.1; the design is that of
``controllers.synthesis.ball_screw_lpv`` (docs/studies/ball_screw_lpv.md).
"""

import json
from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import period, run, system
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_track.json")
K = system(json.loads(DESIGN))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        K.shape[1] - 1
    )


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0


class Output(NamedTuple):
    v_t: Annotated[float, Var("V", "command for tracking")]
    e: Annotated[float, Var("m", "error")]


class Parameters(NamedTuple):
    K: Annotated[FloatArray, Var("1", "[A B; C D] from m to V", fixed=True)] = K


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command of this sample."""
    e = u.r - u.u_c
    x_next, v_t = run(p.K, x.x, e)
    return State(x_next), Output(v_t, e)


model = Sampled(
    "KTrack",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    period_fixed=True,
)
