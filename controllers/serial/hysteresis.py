"""Two gain-scheduled controllers of one axis of which one acts, with hysteresis.

    region 1 → 2 when x_c reaches 0.42 m, 2 → 1 when it is back at 0.38 m

When it switches, the state moves the least that leaves the command as it was
(``bumpless``); without, the state stays, which the common X allows, and the command
jumps.  ``jump`` is how far it is from what the region before would have commanded.
Source: Hanifzadegan 2014, sec. 6.1 and 7.1 (the baseline after [72] with reset after
[61]); the source only says "reset".  Design: ``controllers.synthesis.serial_lpv``.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers import _scheduled
from controllers._scheduled import period, run
from controllers._scheduled_table import Slopes, Table, at, table
from controllers._scheduled_table import prepare as slopes_of
from controllers.serial.lpv import Input
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_hysteresis_1.json")
FIRST = table(DESIGN)
SECOND = table(read_data(__file__, "k_hysteresis_2.json"))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        FIRST.K.shape[1] - 1
    )
    region: Annotated[float, Var("1", "0: none yet, 1 or 2", min=0, max=2)] = 0.0


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    e: Annotated[float, Var("m", "error")]
    region: Annotated[float, Var("1", "region: 1 or 2")]
    jump: Annotated[float, Var("V", "of the command where it switches")]


class Parameters(NamedTuple):
    first: Table = FIRST
    second: Table = SECOND
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65
    x_12: Annotated[float, Var("m", "region 1 ends")] = 0.42
    x_21: Annotated[float, Var("m", "region 2 begins")] = 0.38
    bumpless: Annotated[bool, Var("1", "the command goes on where it switches")] = True


class Derived(NamedTuple):
    first: Slopes
    second: Slopes


def prepare(p: Parameters, T_s: float) -> Derived:
    """Return the slopes of both tables."""
    return Derived(slopes_of(p.first), slopes_of(p.second))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the command of this sample."""
    e, x_c = u.r - u.u_c, p.x_0 - u.u_c
    first, second = at(x_c, p.first, d.first), at(x_c, p.second, d.second)
    region = _scheduled.region(x.region, x_c, p.x_12, p.x_21)
    K: Any = np.where(region < 1.5, first, second)
    before: Any = np.where(x.region < 1.5, first, second)
    switching = np.logical_and(x.region > 0.5, np.abs(region - x.region) > 0.5)
    continued = run(before, x.x, e)[1]
    moved = _scheduled.bumpless(K, x.x, e, continued)
    reset = np.logical_and(switching, p.bumpless)
    x_next, v_m = run(K, np.where(reset, moved, x.x), e)
    jump: Any = np.where(switching, v_m - continued, 0.0)
    return State(x_next, region), Output(v_m, e, region, jump)


model = Sampled(
    "SerialHysteresisLPV",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=prepare,
    period_fixed=True,
)
