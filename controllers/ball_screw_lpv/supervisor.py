"""Supervisor of the switched controller: which region the nut is in.

    region 1 → 2 when x_c >= x_12,   2 → 1 when x_c <= x_21,   else as before

with x_21 < x_12, so that there is no chattering on a border; it starts in the
region that the nut is in, in the overlap in region 1.
Source: Hanifzadegan 2014, sec. 5.1.1 and 5.2.1 (0 to 270 and 250 to 600 mm).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers import _scheduled
from fmus.model import Sampled, Var


class State(NamedTuple):
    region: Annotated[float, Var("1", "0: none yet, 1 or 2", min=0, max=2)] = 0.0


class Input(NamedTuple):
    x_c: Annotated[float, Var("m", "nut distance from the thrust bearing", min=0)] = 0.4


class Output(NamedTuple):
    region: Annotated[float, Var("1", "region: 1 or 2")]


class Parameters(NamedTuple):
    x_12: Annotated[float, Var("m", "region 1 ends", min=0)] = 0.27
    x_21: Annotated[float, Var("m", "region 2 begins", min=0)] = 0.25


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the region of this sample."""
    region = _scheduled.region(x.region, u.x_c, p.x_12, p.x_21)
    return State(region), Output(region)


model = Sampled(
    "RegionSupervisor",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(9, 25_000),
)
