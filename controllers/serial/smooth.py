"""Two gain-scheduled controllers of one axis and their smooth blend.

    K(x_c) = (1 - α) K_1(x_c) + α K_2(x_c),    α from 0.38 to 0.42 m

as a table close enough in the transition; the law of ``controllers.serial.lpv``.
Source: Hanifzadegan 2014, ch. 6 and sec. 7.1; the design is
``controllers.synthesis.serial_lpv.smooth``.
"""

from typing import Annotated, NamedTuple

from controllers._scheduled_table import Table, table
from controllers.serial import lpv
from controllers.serial.lpv import Input, State
from fmus.data import read_data
from fmus.model import Sampled, Var

TABLE = table(read_data(__file__, "k_smooth.json"))


class Parameters(NamedTuple):
    table: Table = TABLE
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


model = Sampled(
    "SerialSmoothLPV",
    lpv.step,
    State(),
    Input(),
    Parameters(),
    period=lpv.model.period,
    prepare=lpv.prepare,
    period_fixed=True,
)
