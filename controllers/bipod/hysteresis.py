"""Two LPV controllers of which one acts, switched with hysteresis.

    region 1 → 2 when φ reaches 75.4 deg, 2 → 1 when it is back at 70 deg

When it switches, the state moves the least that leaves the force as it was
(``bumpless``); without, the state stays, which the common X allows.
Source: Hanifzadegan 2014, sec. 6.1 and 7.2.4 (the baseline after [72]); the source
only says "reset".  The design is that of ``controllers.synthesis.bipod_lpv``.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers import _scheduled
from controllers._scheduled import run
from controllers.bipod._law import Inertia, Input, force
from controllers.bipod._table import Slopes, Table, at, order, table
from controllers.bipod._table import prepare as slopes_of
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

FIRST = table(read_data(__file__, "k_hysteresis_1.json"))
SECOND = table(read_data(__file__, "k_hysteresis_2.json"))


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        order(FIRST)
    )
    region: Annotated[float, Var("1", "0: none yet, 1 or 2", min=0, max=2)] = 0.0


class Output(NamedTuple):
    f_1: Annotated[float, Var("N", "force on slider T1")]
    e: Annotated[float, Var("m", "error")]
    region: Annotated[float, Var("1", "region: 1 or 2")]


class Parameters(NamedTuple):
    first: Table = FIRST
    second: Table = SECOND
    inertia: Inertia = Inertia()
    phi_12: Annotated[float, Var("rad", "region 1 ends")] = 1.3159782568100376
    phi_21: Annotated[float, Var("rad", "region 2 begins")] = 1.2217304763960306
    bumpless: Annotated[bool, Var("1", "the force goes on where it switches")] = True


class Derived(NamedTuple):
    first: Slopes
    second: Slopes


def prepare(p: Parameters, T_s: float) -> Derived:
    """Return the slopes of both tables."""
    return Derived(slopes_of(p.first), slopes_of(p.second))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Return the force of this sample."""
    e = u.r - u.x_1
    first = at(u.phi, u.v_1, p.first, d.first, T_s)
    second = at(u.phi, u.v_1, p.second, d.second, T_s)
    region = _scheduled.region(x.region, u.phi, p.phi_12, p.phi_21)
    K: Any = np.where(region < 1.5, first, second)
    before: Any = np.where(x.region < 1.5, first, second)
    switching = np.logical_and(x.region > 0.5, np.abs(region - x.region) > 0.5)
    moved = _scheduled.bumpless(K, x.x, e, run(before, x.x, e)[1])
    reset = np.logical_and(switching, p.bumpless)
    x_next, y = run(K, np.where(reset, moved, x.x), e)
    f_1 = force(p.first.unit * y, u.phi, p.inertia)
    return State(x_next, region), Output(f_1, e, region)


model = Sampled(
    "BipodHysteresisLPV",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 10_000),
    prepare=prepare,
)
