"""What the adapters of all cyclic modes have in common: encoder, words, torque.

    x = s 2π/N n,   v = s 2π/N ṅ,   τ = s M_N τ' / 1000

with n the position actual value, unwrapped from 32 bits, N increments per revolution,
τ' the torque actual value in thousandths of the rated torque M_N, s = ±1 the side.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.interfaces._words import wrapped
from fmus.model import Var


class Axis(NamedTuple):
    increments: Annotated[float, Var("1", "increments per revolution N", min=1)] = (
        2.0**20
    )
    rated_torque: Annotated[float, Var("N.m", "rated torque M_N", min=0)] = 1.0
    side: Annotated[float, Var("1", "sign s of the drive, 1 or -1", min=-1, max=1)] = (
        1.0
    )


class Turns(NamedTuple):
    n: Annotated[float, Var("1", "position in increments, unwrapped")] = 0.0
    last: Annotated[float, Var("1", "position actual value of the last sample")] = 0.0
    begun: Annotated[float, Var("1", "0 before the first sample, then 1")] = 0.0


class Objects(NamedTuple):
    status_word: Annotated[float, Var("1", "status word, 6041h", min=0)] = 0.0
    position_actual: Annotated[float, Var("1", "position actual value, 6064h")] = 0.0
    velocity_actual: Annotated[float, Var("1/s", "velocity actual value, 606Ch")] = 0.0
    torque_actual: Annotated[float, Var("1", "torque actual value, 6077h")] = 0.0


class Switches(NamedTuple):
    enable: Annotated[bool, Var("1", "operation is asked for")] = True
    reset: Annotated[bool, Var("1", "a fault is acknowledged")] = False


class Feedback(NamedTuple):
    x: Annotated[float, Var("rad", "position")]
    v: Annotated[float, Var("rad/s", "speed")]
    tau: Annotated[float, Var("N.m", "torque")]
    enabled: Annotated[float, Var("1", "1 if the drive follows its target")]


def unwrapped(x: Turns, position_actual: Any) -> Turns:
    """Return the position with this sample's reading, which moved by less than 2³¹."""
    moved = wrapped(position_actual - x.last)
    n = np.where(x.begun > 0.5, x.n + moved, position_actual)
    return Turns(n, position_actual, 1.0)


def per_radian(p: Axis) -> Any:
    """Return increments per radian, with the side."""
    return p.side * p.increments / (2 * np.pi)


def feedback(x: Turns, u: Objects, p: Axis, enabled: Any) -> Feedback:
    """Return what the drive says, in SI units."""
    k = per_radian(p)
    tau = p.side * p.rated_torque * u.torque_actual / 1000
    return Feedback(x.n / k, u.velocity_actual / k, tau, enabled)


def per_mille(tau: Any, p: Axis) -> Any:
    """Return a torque in thousandths of the rated torque, with the side."""
    return p.side * 1000 * tau / p.rated_torque
