"""Notch on the control signal that acts only where the friction is a spring.

    G(s) = (s² + ω²) / (s² + 2ζω s + ω²)    if |e| <= e_n, else 1

Tustin's rule, prewarped at ω.  While it is bypassed the filter is kept at rest on
the passing signal, so that it comes in without a bump.
Source: Maeda 2007, eq. 4-1b, fig. 4-7, sec. 4.5.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters._sections import Section, filtered
from fmus.model import Sampled, Var


class State(NamedTuple):
    w_1: Annotated[float, Var("A", "first memory of the filter")] = 0.0
    w_2: Annotated[float, Var("A", "second memory of the filter")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("A", "control signal")] = 0.0
    e: Annotated[float, Var("mm", "position error")] = 0.0


class Output(NamedTuple):
    u_n: Annotated[float, Var("A", "control signal behind the notch")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "notch acts within e_n")] = False
    omega_hz: Annotated[float, Var("Hz", "notch frequency", min=0)] = 215.0
    zeta: Annotated[float, Var("1", "damping ratio of the poles", min=0)] = 3.0
    e_n: Annotated[float, Var("mm", "microdynamic range", min=0)] = 290e-6


def prepare(p: Parameters, T_s: float) -> Section:
    """Return the discrete notch; its gain at zero frequency is 1."""
    c = np.tan(np.pi * p.omega_hz * T_s)
    a_0 = 1 + 2 * p.zeta * c + c * c
    b_0 = (1 + c * c) / a_0
    b_1 = 2 * (c * c - 1) / a_0
    return Section(b_0, b_1, b_0, b_1, (1 - 2 * p.zeta * c + c * c) / a_0)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Section
) -> tuple[State, Output]:
    """Return the filter's memories and the signal behind it."""
    active = np.logical_and(p.on, np.abs(u.e) <= p.e_n)
    w_1, w_2, y = filtered(x.w_1, x.w_2, u.u, d)
    w_1 = np.where(active, w_1, (1 - d.b_0) * u.u)
    w_2 = np.where(active, w_2, (d.b_2 - d.a_2) * u.u)
    u_n: Any = np.where(active, y, u.u)
    return State(w_1, w_2), Output(u_n)


model = Sampled(
    "ConditionalNotch",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
    prepare=prepare,
)
