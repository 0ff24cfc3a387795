"""Two LPV controllers that hand over smoothly between 70 and 75.4 deg.

    K(φ) = (1 - α) K_1 + α K_2,     α = 10s³ - 15s⁴ + 6s⁵,    s = (φ - φ_1)/(φ_2 - φ_1)

The blend stands in the table, 57 angles, since it is the blended continuous system
that is certified.  Otherwise as ``lpv``.
Source: Hanifzadegan 2014, sec. 6.1.3, eq. 6.19 to 6.21, 7.18 to 7.21; the design is
that of ``controllers.synthesis.bipod_lpv``, by the descent of sec. 6.3.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.bipod import lpv
from controllers.bipod._law import Inertia, Input
from controllers.bipod._table import Table, order, table
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

TABLE = table(read_data(__file__, "k_smooth_tuned.json"))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        order(TABLE)
    )


class Parameters(NamedTuple):
    table: Table = TABLE
    inertia: Inertia = Inertia()


model = Sampled(
    "BipodSmoothLPV",
    lpv.step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 10_000),
    prepare=lpv.prepare,
)
