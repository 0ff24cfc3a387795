"""NCTF controller: the whole controller in one sample.

    u_p = v_NCT(e) + ẋ_r - ẋ                       without ẋ_r point to point
    u   = notch(K_p u_p + u_i),   u_i⁺ = u_i + K_i T_s u_p, frozen in saturation

The parts are models of their own; here they run one after the other at the same
instant.  With a conventional trajectory, table 5-1's controller 1; with a fast one
(MFNCT, MFNCTS) another table and other gains.
Source: Maeda 2007, fig. 3-9, 4-7 and 6-2.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.filters._sections import Section
from controllers.leadscrew import compensator as nct_compensator
from controllers.leadscrew import conditional_notch
from controllers.leadscrew import nominal_trajectory as nct_element
from controllers.leadscrew.nominal_trajectory import POINTS, Input
from fmus.model import FloatArray, Sampled, Var


class State(NamedTuple):
    element: nct_element.State = nct_element.State()
    compensator: nct_compensator.State = nct_compensator.State()
    notch: conditional_notch.State = conditional_notch.State()


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]
    e: Annotated[float, Var("mm", "position error")]
    u_p: Annotated[float, Var("mm/s", "distance from the trajectory")]


class Parameters(NamedTuple):
    e_nct: Annotated[
        FloatArray, Var("mm", "errors of the trajectory, ascending", fixed=True)
    ] = np.linspace(0.0, 1.0, POINTS)
    edot_nct: Annotated[
        FloatArray, Var("mm/s", "error rates of the trajectory", fixed=True)
    ] = np.linspace(0.0, 16.5, POINTS)
    K_p: Annotated[float, Var("A.s/mm", "proportional gain")] = 0.981
    K_i: Annotated[float, Var("A/mm", "integral gain")] = 156.9
    u_s: Annotated[float, Var("A", "where the actuator saturates", min=0)] = 6.0
    anti_windup: Annotated[bool, Var("1", "freeze the integral")] = True
    continuous: Annotated[bool, Var("1", "add the reference velocity")] = False
    notch: conditional_notch.Parameters = conditional_notch.Parameters()


def prepare(p: Parameters, T_s: float) -> Section:
    """Return the discrete notch."""
    return conditional_notch.prepare(p.notch, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Section
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""
    x_element, element = nct_element.step(
        x.element,
        u,
        nct_element.Parameters(p.e_nct, p.edot_nct, p.continuous),
        T_s,
    )
    x_compensator, compensator = nct_compensator.step(
        x.compensator,
        nct_compensator.Input(element.u_p),
        nct_compensator.Parameters(p.K_p, p.K_i, p.u_s, p.anti_windup),
        T_s,
    )
    x_notch, notch = conditional_notch.step(
        x.notch,
        conditional_notch.Input(compensator.u, element.e),
        p.notch,
        T_s,
        d,
    )
    x_next = State(x_element, x_compensator, x_notch)
    return x_next, Output(notch.u_n, element.e, element.u_p)


model = Sampled(
    "NCTF",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
    prepare=prepare,
)
