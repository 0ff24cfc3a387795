"""Tracking by the redesigned K_track with K_vib: the whole controller in one sample.

    v_m = K_track,damped (r - u_c) + K_vib(x_c) (u_m - u_c)

The redesigned K_track is unstable on the undamped drive: K_vib cannot be left out.
Source: Hanifzadegan 2014, fig. 4.1 and 4.5.
"""

from typing import Annotated, NamedTuple

from controllers._scheduled_table import Slopes
from controllers.ball_screw_lpv import k_track, k_track_damped
from controllers.ball_screw_lpv import k_vib as k_v
from controllers.ball_screw_lpv.lpv import Input
from fmus.model import Sampled, Var


class State(NamedTuple):
    track: k_track_damped.State = k_track_damped.State()
    vibration: k_v.State = k_v.State()


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    v_t: Annotated[float, Var("V", "part for tracking")]
    v_v: Annotated[float, Var("V", "part against vibration")]
    e: Annotated[float, Var("m", "error")]


class Parameters(NamedTuple):
    track: k_track_damped.Parameters = k_track_damped.Parameters()
    k_vib: k_v.Parameters = k_v.Parameters()


def prepare(p: Parameters, T_s: float) -> Slopes:
    """Prepare the table of K_vib."""
    return k_v.prepare(p.k_vib, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Slopes
) -> tuple[State, Output]:
    """Run the parts at the same instant."""
    told = k_v.Input(u.u_m, u.u_c)
    vibration, y = k_v.step(x.vibration, told, p.k_vib, T_s, d)
    command = k_track.Input(u.r, u.u_c)
    track, tracking = k_track_damped.step(x.track, command, p.track, T_s)
    v_m = tracking.v_t + y.v_v
    return State(track, vibration), Output(v_m, tracking.v_t, y.v_v, tracking.e)


model = Sampled(
    "LPVControlDamped",
    step,
    State(),
    Input(),
    Parameters(),
    period=k_v.model.period,
    prepare=prepare,
    period_fixed=True,
)
