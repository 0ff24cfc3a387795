"""Gain-scheduled control over the whole stroke: the whole controller in one sample.

    v_m = K_track (r - u_c) + K_vib(x_c, m_wor) (u_m - u_c) - d̂

The source's "Case II" of chapter 5, to which switching is compared.
Source: Hanifzadegan 2014, fig. 5.1 with one region, sec. 5.2.
"""

from typing import Annotated, NamedTuple

from controllers._scheduled_table import Slopes
from controllers.ball_screw_lpv import _tracking, k_track, k_vib_one_region
from controllers.ball_screw_lpv import observer as dob
from controllers.ball_screw_lpv._tracking import Output
from fmus.model import Sampled, Var


class State(NamedTuple):
    tracking: _tracking.State = _tracking.State()
    vibration: k_vib_one_region.State = k_vib_one_region.State()


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.0
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0
    m_wor: Annotated[float, Var("kg", "mass of the workpiece", min=0)] = 0.0


class Parameters(NamedTuple):
    tracking: _tracking.Parameters = _tracking.Parameters()
    k_vib: k_vib_one_region.Parameters = k_vib_one_region.Parameters()


class Derived(NamedTuple):
    observer: dob.Derived
    vibration: Slopes


def prepare(p: Parameters, T_s: float) -> Derived:
    """Prepare the parts."""
    return Derived(
        dob.prepare(p.tracking.observer, T_s),
        k_vib_one_region.prepare(p.k_vib, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts at the same instant."""
    told = k_vib_one_region.Input(u.u_m, u.u_c, u.m_wor)
    vibration, y = k_vib_one_region.step(x.vibration, told, p.k_vib, T_s, d.vibration)
    command = k_track.Input(u.r, u.u_c)
    tracking, whole = _tracking.step(
        x.tracking, command, y.v_v, p.tracking, T_s, d.observer
    )
    return State(tracking, vibration), whole


model = Sampled(
    "OneRegionLPVControl",
    step,
    State(),
    Input(),
    Parameters(),
    period=k_vib_one_region.model.period,
    prepare=prepare,
    period_fixed=True,
)
