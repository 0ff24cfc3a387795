"""Parallel tracking and vibration control: the whole controller in one sample.

    v_m = K_track (r - u_c) + K_vib(x_c) (u_m - u_c) - d̂

"Case I" is ``vibration`` off, "Case II" on; the observer is off unless asked for.
The parts are models of their own.
Source: Hanifzadegan 2014, fig. 4.1, sec. 4.3 and 4.5.
"""

from typing import Annotated, NamedTuple

from controllers._scheduled_table import Slopes
from controllers.ball_screw_lpv import _tracking, k_track
from controllers.ball_screw_lpv import k_vib as k_v
from controllers.ball_screw_lpv import observer as dob
from controllers.ball_screw_lpv._tracking import Output
from fmus.model import Sampled, Var


class State(NamedTuple):
    tracking: _tracking.State = _tracking.State()
    vibration: k_v.State = k_v.State()


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.0
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0


class Parameters(NamedTuple):
    tracking: _tracking.Parameters = _tracking.Parameters()
    k_vib: k_v.Parameters = k_v.Parameters()


class Derived(NamedTuple):
    observer: dob.Derived
    vibration: Slopes


def prepare(p: Parameters, T_s: float) -> Derived:
    """Prepare the parts."""
    return Derived(dob.prepare(p.tracking.observer, T_s), k_v.prepare(p.k_vib, T_s))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts at the same instant."""
    told = k_v.Input(u.u_m, u.u_c)
    vibration, y = k_v.step(x.vibration, told, p.k_vib, T_s, d.vibration)
    command = k_track.Input(u.r, u.u_c)
    tracking, whole = _tracking.step(
        x.tracking, command, y.v_v, p.tracking, T_s, d.observer
    )
    return State(tracking, vibration), whole


model = Sampled(
    "LPVControl",
    step,
    State(),
    Input(),
    Parameters(),
    period=k_v.model.period,
    prepare=prepare,
    period_fixed=True,
)
