"""Vibration controllers of two regions, of which one acts at a time.

    x⁺ = A_i(x_c, m_wor) x + B_i(x_c, m_wor) y,     y = u_m - u_c,  i = region
    v_v = C_i(x_c, m_wor) x + D_i(x_c, m_wor) y

The designs share X, hence the state: switching changes the matrices and resets
nothing.  Source: Hanifzadegan 2014, sec. 5.1, eq. 5.2 to 5.8, Table 5.1.
"""

from typing import Annotated, Any, NamedTuple

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

FIRST = read_data(__file__, "k_vib_region_1.json")
SECOND = read_data(__file__, "k_vib_region_2.json")


class State(NamedTuple):
    x: Annotated[FloatArray, Var("1", "states in balanced coordinates")] = np.zeros(
        table_of_mass(FIRST).K.shape[1] - 1
    )


class Input(NamedTuple):
    u_m: Annotated[float, Var("m", "motor position as table travel")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0
    m_wor: Annotated[float, Var("kg", "mass of the workpiece", min=0)] = 0.0
    region: Annotated[float, Var("1", "region: 1 or 2", min=1, max=2)] = 1.0


class Output(NamedTuple):
    v_v: Annotated[float, Var("V", "command against vibration")]


class Parameters(NamedTuple):
    first: TableOfMass = table_of_mass(FIRST)
    second: TableOfMass = table_of_mass(SECOND)
    x_0: Annotated[float, Var("m", "nut distance at u_c = 0")] = 0.65


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
    x_c = p.x_0 - u.u_c
    first = at_mass(x_c, u.m_wor, p.first, d.first)
    second = at_mass(x_c, u.m_wor, p.second, d.second)
    K: Any = np.where(u.region < 1.5, first, second)
    x_next, v_v = run(K, x.x, u.u_m - u.u_c)
    return State(x_next), Output(v_v)


model = Sampled(
    "KVibSwitched",
    step,
    State(),
    Input(),
    Parameters(),
    period=period(FIRST),
    prepare=prepare,
    period_fixed=True,
)
