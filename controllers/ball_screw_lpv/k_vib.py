"""Vibration controller K_vib(x_c), scheduled by the nut distance.

    x⁺ = A(x_c) x + B(x_c) y,   v_v = C(x_c) x + D(x_c) y,   y = u_m - u_c

The difference of the two positions, not either of them: a gain on an absolute
position would spoil tracking.  x_c = x_0 - u_c from the same sample.
Source: Hanifzadegan 2014, sec. 4.3.2 and 4.4.2, eq. 4.9 to 4.12, Table 4.1; the
design is that of ``controllers.synthesis.ball_screw_lpv``.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import period, run
from controllers._scheduled_table import Slopes, Table, at, table
from controllers._scheduled_table import prepare as slopes_of
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_vib.json")
TABLE = table(DESIGN)


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        TABLE.K.shape[1] - 1
    )


class Input(NamedTuple):
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0


class Output(NamedTuple):
    v_v: Annotated[float, Var("V", "command against vibration")]


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
    x_next, v_v = run(at(p.x_0 - u.u_c, p.table, d), x.x, u.u_m - u.u_c)
    return State(x_next), Output(v_v)


model = Sampled(
    "KVib",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=prepare,
    period_fixed=True,
)
