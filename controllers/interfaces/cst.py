"""Adapter for drives in cyclic synchronous torque mode (CiA 402, CST).

    target torque  6071h = ⌊s 1000 τ_r / M_N + ½⌋              thousandths of M_N

The target is zero until the drive has reached operation enabled.
Source: IEC 61800-7-201 (CiA 402), cyclic synchronous torque mode.
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
    unwrapped,
)
from controllers.interfaces._cia402 import control_word, operation_enabled
from controllers.interfaces._words import limited
from fmus.model import Included, Sampled, Var


class Input(NamedTuple):
    tau_r: Annotated[float, Var("N.m", "torque reference")] = 0.0
    objects: Annotated[Objects, Included()] = Objects()


class Output(NamedTuple):
    control_word: Annotated[float, Var("1", "control word, 6040h")]
    target_torque: Annotated[float, Var("1", "target torque, 6071h")]
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
        enabled * limited(per_mille(u.tau_r, axis), 16),
        feedback(turns, u.objects, axis, enabled),
    )


model = Sampled(
    "CyclicTorque",
    step,
    Turns(),
    Input(),
    Parameters(),
    period=Fraction(1, 1000),
)
