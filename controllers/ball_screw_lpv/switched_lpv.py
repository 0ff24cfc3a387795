"""Switching gain-scheduled control: the whole controller in one sample.

    v_m = K_track (r - u_c) + K_vib,i(x_c, m_wor) (u_m - u_c) - d̂,   i = region(x_c)

The supervisor decides from the same sample.  The source designs one switched
controller for tracking and vibration, which its own weights do not yield; here
K_track of chapter 4 stays and K_vib switches (docs/studies/ball_screw_lpv.md).
Source: Hanifzadegan 2014, fig. 5.1, sec. 5.1 and 5.2.
"""

from typing import Annotated, NamedTuple

from controllers.ball_screw_lpv import _tracking, k_track, k_vib_switched
from controllers.ball_screw_lpv import observer as dob
from controllers.ball_screw_lpv import supervisor as regions
from controllers.ball_screw_lpv._tracking import Output as Tracking
from fmus.model import Sampled, Var


class State(NamedTuple):
    supervisor: regions.State = regions.State()
    tracking: _tracking.State = _tracking.State()
    vibration: k_vib_switched.State = k_vib_switched.State()


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.0
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0
    m_wor: Annotated[float, Var("kg", "mass of the workpiece", min=0)] = 0.0


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    v_t: Annotated[float, Var("V", "part for tracking")]
    v_v: Annotated[float, Var("V", "part against vibration")]
    d: Annotated[float, Var("V", "estimated disturbance")]
    e: Annotated[float, Var("m", "error")]
    region: Annotated[float, Var("1", "region: 1 or 2")]


class Parameters(NamedTuple):
    supervisor: regions.Parameters = regions.Parameters()
    tracking: _tracking.Parameters = _tracking.Parameters()
    k_vib: k_vib_switched.Parameters = k_vib_switched.Parameters()


class Derived(NamedTuple):
    observer: dob.Derived
    vibration: k_vib_switched.Derived


def prepare(p: Parameters, T_s: float) -> Derived:
    """Prepare the parts."""
    return Derived(
        dob.prepare(p.tracking.observer, T_s),
        k_vib_switched.prepare(p.k_vib, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts at the same instant."""
    seen = regions.Input(p.k_vib.x_0 - u.u_c)
    state, chosen = regions.step(x.supervisor, seen, p.supervisor, T_s)
    told = k_vib_switched.Input(u.u_m, u.u_c, u.m_wor, chosen.region)
    vibration, y = k_vib_switched.step(x.vibration, told, p.k_vib, T_s, d.vibration)
    command = k_track.Input(u.r, u.u_c)
    tracking, whole = _tracking.step(
        x.tracking, command, y.v_v, p.tracking, T_s, d.observer
    )
    return State(state, tracking, vibration), finished(whole, chosen.region)


def finished(y: Tracking, region: float) -> Output:
    """Return the outputs with the region."""
    return Output(y.v_m, y.v_t, y.v_v, y.d, y.e, region)


model = Sampled(
    "SwitchedLPVControl",
    step,
    State(),
    Input(),
    Parameters(),
    period=k_vib_switched.model.period,
    prepare=prepare,
    period_fixed=True,
)
