"""Adapter for drives with PROFIdrive telegram 105, dynamic servo control (DSC).

    NSOLL_B = ⌊2³⁰ s v_r / n_N + ½⌋          XERR = ⌊s N/2π (x_r - x) + ½⌋
    KPC     = ⌊1000 K_v + ½⌋                 v = n_N NIST_B / 2³⁰ s

The drive closes the position loop: it adds KPC times XERR, less what it has moved
since, to NSOLL.  Control word STW1: 047Eh until the drive is ready to switch on,
047Fh from then on, 04FEh to acknowledge a fault; all setpoints are zero until status
word ZSW1 says operation enabled (bit 2).  n_N is the reference speed, N the increments
per revolution of G1_XIST1, s = ±1 the side.
Source: PROFIdrive profile 4.2 (PI), telegram 105, normalisation N4 of NSOLL and NIST,
DSC with KPC in 1/1000 s⁻¹.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.interfaces._axis import Turns, unwrapped
from controllers.interfaces._words import bit, limited
from fmus.model import Sampled, Var

FULL = 2.0**30  # 40000000h, the reference speed
OFF, ON, ACKNOWLEDGE = 1150.0, 1151.0, 1278.0  # 047Eh, 047Fh, 04FEh


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "position reference")] = 0.0
    v_r: Annotated[float, Var("rad/s", "speed reference")] = 0.0
    zsw1: Annotated[float, Var("1", "status word 1", min=0)] = 0.0
    nist_b: Annotated[float, Var("1", "actual speed, 32 bits")] = 0.0
    g1_xist1: Annotated[float, Var("1", "actual position, 32 bits")] = 0.0


class Output(NamedTuple):
    stw1: Annotated[float, Var("1", "control word 1")]
    nsoll_b: Annotated[float, Var("1", "speed setpoint, 32 bits")]
    xerr: Annotated[float, Var("1", "position deviation, 32 bits")]
    kpc: Annotated[float, Var("1", "position controller gain, 32 bits")]
    x: Annotated[float, Var("rad", "position")]
    v: Annotated[float, Var("rad/s", "speed")]
    enabled: Annotated[float, Var("1", "1 if the drive follows its setpoint")]


class Parameters(NamedTuple):
    increments: Annotated[float, Var("1", "increments per revolution N", min=1)] = (
        2.0**20
    )
    reference_speed: Annotated[float, Var("rad/s", "reference speed n_N", min=0)] = (
        100.0
    )
    K_v: Annotated[float, Var("1/s", "position loop gain", min=0)] = 100.0
    side: Annotated[float, Var("1", "sign s of the drive, 1 or -1", min=-1, max=1)] = (
        1.0
    )
    enable: Annotated[bool, Var("1", "operation is asked for")] = True
    reset: Annotated[bool, Var("1", "a fault is acknowledged")] = False


def step(x: Turns, u: Input, p: Parameters, T_s: float) -> tuple[Turns, Output]:
    """Return the words of this sample and what the drive says."""
    turns = unwrapped(x, u.g1_xist1)
    per_radian = p.side * p.increments / (2 * np.pi)
    per_speed = p.side * FULL / p.reference_speed
    enabled = bit(u.zsw1, 2) * (1 - bit(u.zsw1, 3))
    inhibited, ready = bit(u.zsw1, 6), bit(u.zsw1, 0)
    asked = np.where(p.enable, 1.0, 0.0) * (1 - inhibited) * ready
    word = np.where(asked > 0.5, ON, OFF)
    acknowledge = np.where(p.reset, ACKNOWLEDGE, OFF)
    told: Any = np.where(bit(u.zsw1, 3) > 0.5, acknowledge, word)
    position = turns.n / per_radian
    return turns, Output(
        told,
        enabled * limited(per_speed * u.v_r, 32),
        enabled * limited(per_radian * (u.x_r - position), 32),
        enabled * limited(1000 * p.K_v, 32),
        position,
        u.nist_b / per_speed,
        enabled,
    )


model = Sampled(
    "Telegram105",
    step,
    Turns(),
    Input(),
    Parameters(),
    period=Fraction(1, 1000),
)
