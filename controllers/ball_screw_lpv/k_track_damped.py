"""Tracking controller for the drive that K_vib damps: K_track designed once more.

    x⁺ = A x + B e,   v_t = C x + D e,   e = r - u_c

With K_vib closed at 0.4 m the design may ask for more (W_v 1e-4 instead of 6e-4) and
the loop follows the reference to about 1500 rad/s; without K_vib it is unstable.
Source: Hanifzadegan 2014, sec. 4.4.2 and fig. 4.5 (1500 rad/s with K_vib); that
K_track is designed anew for it is our reading (docs/studies/ball_screw_lpv.md).
"""

import json
from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import period, run, system
from controllers.ball_screw_lpv.k_track import Input, Output
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_track_damped.json")
K = system(json.loads(DESIGN))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        K.shape[1] - 1
    )


class Parameters(NamedTuple):
    K: Annotated[FloatArray, Var("1", "[A B; C D] from m to V", fixed=True)] = K


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command of this sample."""
    e = u.r - u.u_c
    x_next, v_t = run(p.K, x.x, e)
    return State(x_next), Output(v_t, e)


model = Sampled(
    "KTrackDamped",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    period_fixed=True,
)
