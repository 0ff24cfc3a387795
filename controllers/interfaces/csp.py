"""Adapter for drives in cyclic synchronous position mode (CiA 402, CSP).

    target position  607Ah = wrap32(⌊s N/2π x_r + ½⌋)          increments
    velocity offset  60B1h = ⌊s N/2π v_ff + ½⌋                 increments per second
    torque offset    60B2h = ⌊s 1000 τ_ff / M_N + ½⌋           thousandths of M_N

Until the drive has reached operation enabled the target is its actual position, so
that it does not jump.  A sample's status is answered in the same sample.
Source: IEC 61800-7-201 (CiA 402), cyclic synchronous position mode.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.interfaces._axis import (
    Axis,
    Feedback,
    Objects,
    Switches,
    Turns,
    feedback,
    per_mille,
    per_radian,
    unwrapped,
)
from controllers.interfaces._cia402 import control_word, operation_enabled
from controllers.interfaces._words import limited, whole, wrapped
from fmus.model import Included, Sampled, Var


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "position reference")] = 0.0
    v_ff: Annotated[float, Var("rad/s", "speed fed forward")] = 0.0
    tau_ff: Annotated[float, Var("N.m", "torque fed forward")] = 0.0
    objects: Annotated[Objects, Included()] = Objects()


class Output(NamedTuple):
    control_word: Annotated[float, Var("1", "control word, 6040h")]
    target_position: Annotated[float, Var("1", "target position, 607Ah")]
    velocity_offset: Annotated[float, Var("1/s", "velocity offset, 60B1h")]
    torque_offset: Annotated[float, Var("1", "torque offset, 60B2h")]
    feedback: Annotated[Feedback, Included()]


class Parameters(NamedTuple):
    axis: Annotated[Axis, Included()] = Axis()
    switches: Annotated[Switches, Included()] = Switches()


def step(x: Turns, u: Input, p: Parameters, T_s: float) -> tuple[Turns, Output]:
    """Return the objects of this sample and what the drive says."""
    axis, status = p.axis, u.objects.status_word
    turns = unwrapped(x, u.objects.position_actual)
    enabled = operation_enabled(status)
    k = per_radian(axis)
    reached = wrapped(whole(k * u.x_r))
    target: Any = np.where(enabled > 0.5, reached, u.objects.position_actual)
    return turns, Output(
        control_word(status, p.switches.enable, p.switches.reset),
        target,
        enabled * limited(k * u.v_ff, 32),
        enabled * limited(per_mille(u.tau_ff, axis), 16),
        feedback(turns, u.objects, axis, enabled),
    )


model = Sampled(
    "CyclicPosition",
    step,
    Turns(),
    Input(),
    Parameters(),
    period=Fraction(1, 1000),
)
