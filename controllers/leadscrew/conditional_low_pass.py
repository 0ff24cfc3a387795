"""Low-pass on the control signal, the alternative to the notch that the source rejects.

    G(s) = ω² / (s² + 2ζω s + ω²)    if |e| <= e_n, else 1

Its gain at ω is 1/(2ζ), so that vibration there is damped by the choice of ζ alone,
and lower frequencies with it; the notch's is 0 for any ζ.  Tustin's rule, prewarped at
ω; bypassed as ``controllers.leadscrew.conditional_notch`` is.
Source: Maeda 2007, eq. 4-1a, fig. 4-6.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.filters._sections import Section
from controllers.leadscrew import conditional_notch
from controllers.leadscrew.conditional_notch import Input, State
from fmus.model import Sampled, Var


class Output(NamedTuple):
    u_f: Annotated[float, Var("A", "control signal behind the low-pass")]


class Parameters(NamedTuple):
    on: Annotated[bool, Var("1", "low-pass acts within e_n")] = False
    omega_hz: Annotated[float, Var("Hz", "natural frequency", min=0)] = 215.0
    zeta: Annotated[float, Var("1", "damping ratio", min=0)] = 3.0
    e_n: Annotated[float, Var("mm", "microdynamic range", min=0)] = 290e-6


def prepare(p: Parameters, T_s: float) -> Section:
    """Return the discrete low-pass; its gain at zero frequency is 1."""
    c = np.tan(np.pi * p.omega_hz * T_s)
    a_0 = 1 + 2 * p.zeta * c + c * c
    b = c * c / a_0
    a_1 = 2 * (c * c - 1) / a_0
    return Section(b, 2 * b, b, a_1, (1 - 2 * p.zeta * c + c * c) / a_0)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Section
) -> tuple[State, Output]:
    """Return the filter's memories and the signal behind it."""
    within = conditional_notch.Parameters(p.on, p.omega_hz, p.zeta, p.e_n)
    x_next, y = conditional_notch.step(x, u, within, T_s, d)
    return x_next, Output(y.u_n)


model = Sampled(
    "ConditionalLowPass",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
    prepare=prepare,
)
