"""Vibration controller over the whole stroke, scheduled by position and mass.

    x⁺ = A(x_c, m_wor) x + B(x_c, m_wor) y,     y = u_m - u_c
    v_v = C(x_c, m_wor) x + D(x_c, m_wor) y

The source's "Case II" of chapter 5: the same design without switching.
Source: Hanifzadegan 2014, sec. 5.2.1, Table 5.1.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers._scheduled import period, run
from controllers._scheduled_table import (
    Slopes,
    TableOfMass,
    at_mass,
    table_of_mass,
)
from controllers._scheduled_table import prepare as slopes_of
from fmus.data import read_data
from fmus.model import FloatArray, Sampled, Var

DESIGN = read_data(__file__, "k_vib_one_region.json")
TABLE = table_of_mass(DESIGN)


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        TABLE.K.shape[1] - 1
    )


class Input(NamedTuple):
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0
    m_wor: Annotated[float, Var("kg", "mass of the workpiece", min=0)] = 0.0


class Output(NamedTuple):
    v_v: Annotated[float, Var("V", "command against vibration")]


class Parameters(NamedTuple):
    table: TableOfMass = TABLE
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


def prepare(p: Parameters, T_s: float) -> Slopes:
    """Return the slopes of the table over the nut distance."""
    return slopes_of(p.table)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Slopes
) -> tuple[State, Output]:
    """Return the command of this sample."""
    K = at_mass(p.x_0 - u.u_c, u.m_wor, p.table, d)
    x_next, v_v = run(K, x.x, u.u_m - u.u_c)
    return State(x_next), Output(v_v)


model = Sampled(
    "KVibOneRegion",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(DESIGN),
    prepare=prepare,
    period_fixed=True,
)
