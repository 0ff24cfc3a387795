"""Gain-scheduled controller of one axis, designed against the printed disturbance.

    x⁺ = A(x_c) x + B(x_c) e,   v_m = C(x_c) x + D(x_c) e,   e = r - u_c

The law of ``controllers.serial.lpv`` with another table.
Source: Hanifzadegan 2014, sec. 7.1; the design is ``controllers.synthesis.serial_lpv``.
"""

from typing import Annotated, NamedTuple

from controllers._scheduled import period
from controllers._scheduled_table import Table, table
from controllers.serial import lpv
from controllers.serial.lpv import Input, State
from fmus.data import read_data
from fmus.model import Sampled, Var

DESIGN = read_data(__file__, "k_disturbed.json")
TABLE = table(DESIGN)


class Parameters(NamedTuple):
    table: Table = TABLE
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


model = Sampled(
    "SerialLPVDisturbed",
    lpv.step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=lpv.prepare,
    period_fixed=True,
)
