"""Adapter for drives in cyclic synchronous velocity mode (CiA 402, CSV).

    target velocity  60FFh = ⌊s N/2π v_r + ½⌋                  increments per second
    torque offset    60B2h = ⌊s 1000 τ_ff / M_N + ½⌋           thousandths of M_N

The target is zero until the drive has reached operation enabled.
Source: IEC 61800-7-201 (CiA 402), cyclic synchronous velocity mode.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

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
from controllers.interfaces._words import limited
from fmus.model import Included, Sampled, Var


class Input(NamedTuple):
    v_r: Annotated[float, Var("rad/s", "speed reference")] = 0.0
    tau_ff: Annotated[float, Var("N.m", "torque fed forward")] = 0.0
    objects: Annotated[Objects, Included()] = Objects()


class Output(NamedTuple):
    control_word: Annotated[float, Var("1", "control word, 6040h")]
    target_velocity: Annotated[float, Var("1/s", "target velocity, 60FFh")]
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
    return turns, Output(
        control_word(status, p.switches.enable, p.switches.reset),
        enabled * limited(per_radian(axis) * u.v_r, 32),
        enabled * limited(per_mille(u.tau_ff, axis), 16),
        feedback(turns, u.objects, axis, enabled),
    )


model = Sampled(
    "CyclicVelocity",
    step,
    Turns(),
    Input(),
    Parameters(),
    period=Fraction(1, 1000),
)
