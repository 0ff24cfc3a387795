"""One LPV controller for the whole range of angles.

    (x⁺, u) = K(φ, ẋ_1) (x, e),    f_1 = H_1(φ) ν,    e = r - x_1

The design with calibrated weights; φ and ẋ_1 are those of the same sample.
Source: Hanifzadegan 2014, sec. 7.2.3 and 7.2.4 (the non-switching controller); the
design is that of ``controllers.synthesis.bipod_lpv``.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import run
from controllers.bipod._law import Inertia, Input, Output, force
from controllers.bipod._table import Slopes, Table, at, order, table
from controllers.bipod._table import prepare as slopes_of
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

TABLE = table(read_data(__file__, "k_tuned.json"))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        order(TABLE)
    )


class Parameters(NamedTuple):
    table: Table = TABLE
    inertia: Inertia = Inertia()


def prepare(p: Parameters, T_s: float) -> Slopes:
    """Return the slopes of the table."""
    return slopes_of(p.table)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Slopes
) -> tuple[State, Output]:
    """Return the force of this sample."""
    e = u.r - u.x_1
    x_next, y = run(at(u.phi, u.v_1, p.table, d, T_s), x.x, e)
    return State(x_next), Output(force(p.table.unit * y, u.phi, p.inertia), e)


model = Sampled(
    "BipodLPV",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 10_000),
    prepare=prepare,
)
