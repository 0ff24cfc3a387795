"""Tracking and disturbance observer, the parts that both whole controllers share.

    v_m = K_track (r - u_c) + v_v - d̂

Source: Hanifzadegan 2014, fig. 4.1.
"""

from typing import Annotated, Any, NamedTuple

from controllers.ball_screw_lpv import k_track
from controllers.ball_screw_lpv import observer as dob
from fmus.model import Var


class State(NamedTuple):
    track: k_track.State = k_track.State()
    observer: dob.State = dob.State()
    v_m: Annotated[float, Var("V", "whole command of the sample before")] = 0.0


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    v_t: Annotated[float, Var("V", "part for tracking")]
    v_v: Annotated[float, Var("V", "part against vibration")]
    d: Annotated[float, Var("V", "estimated disturbance")]
    e: Annotated[float, Var("m", "error")]


class Parameters(NamedTuple):
    track: k_track.Parameters = k_track.Parameters()
    vibration: Annotated[bool, Var("1", "K_vib acts")] = True
    observe: Annotated[bool, Var("1", "the disturbance observer acts")] = False
    observer: dob.Parameters = dob.Parameters()


def step(
    x: State,
    told: k_track.Input,
    v_v: Any,
    p: Parameters,
    T_s: float,
    d: dob.Derived,
) -> tuple[State, Output]:
    """Add tracking and observer to the command against vibration, v_v."""
    track, tracking = k_track.step(x.track, told, p.track, T_s)
    seen = dob.Input(told.u_c, x.v_m)
    observing, estimate = dob.step(x.observer, seen, p.observer, T_s, d)
    v_v = p.vibration * v_v
    v_m = tracking.v_t + v_v - p.observe * estimate.d
    y = Output(v_m, tracking.v_t, v_v, estimate.d, tracking.e)
    return State(track, observing, v_m), y
