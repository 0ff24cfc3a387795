"""Mass of a workpiece that is cut away.

    m_wor = m_0 - ṁ (t - t_on),    held before t_on and from t_off on, never below 0

Source: Hanifzadegan 2014, sec. 1.5.1 and 5.1 (the mass falls during the cut; in the
experiments it was 0 or 10 kg throughout), ṁ is our choice.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The mass follows the clock alone."""


class Output(NamedTuple):
    m_wor: Annotated[float, Var("kg", "mass of the workpiece")]


class Parameters(NamedTuple):
    m_0: Annotated[float, Var("kg", "mass before the cut", min=0)] = 10.0
    rate: Annotated[float, Var("kg/s", "mass cut away per second", min=0)] = 0.0
    t_on: Annotated[float, Var("s", "the cut begins", min=0)] = 0.0
    t_off: Annotated[float, Var("s", "the cut ends", min=0)] = 1e6


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the mass of this sample."""
    t = np.minimum(np.maximum(x.k * T_s, p.t_on), p.t_off)
    m_wor: Any = np.maximum(p.m_0 - p.rate * (t - p.t_on), 0.0)
    return State(x.k + 1), Output(m_wor)


model = Sampled(
    "Workpiece", step, State(), Input(), Parameters(), period=Fraction(3, 50_000)
)
