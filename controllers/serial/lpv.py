"""Gain-scheduled controller of one axis, without switching.

    x⁺ = A(x_c) x + B(x_c) e,   v_m = C(x_c) x + D(x_c) e,   e = r - u_c

x_c = x_0 - u_c from the same sample.  Designed with the disturbance all but off;
``controllers.serial.lpv_disturbed`` is the same with the disturbance as printed.
Source: Hanifzadegan 2014, sec. 7.1; the design is ``controllers.synthesis.serial_lpv``.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import period, run
from controllers._scheduled_table import Slopes, Table, at, table
from controllers._scheduled_table import prepare as slopes_of
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_undisturbed.json")
TABLE = table(DESIGN)


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        TABLE.K.shape[1] - 1
    )


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.25
    u_c: Annotated[float, Var("m", "table position")] = 0.25


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    e: Annotated[float, Var("m", "error")]


class Parameters(NamedTuple):
    table: Table = TABLE
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def prepare(p: Parameters, T_s: float) -> Slopes:
    """Return the slopes of the table."""
    return slopes_of(p.table)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Slopes
) -> tuple[State, Output]:
    """Return the command of this sample."""
    e = u.r - u.u_c
    x_next, v_m = run(at(p.x_0 - u.u_c, p.table, d), x.x, e)
    return State(x_next), Output(v_m, e)


model = Sampled(
    "SerialLPV",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=prepare,
    period_fixed=True,
)
