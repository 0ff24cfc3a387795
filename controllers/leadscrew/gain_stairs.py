"""Search for the ultimate gain: NCTF control whose K_p rises stair by stair.

    K_p = K_p1 qⁿ on the n-th stair, n = 0, 1, 2, …, each T_d long

The integral gain stays what it is: zero to find K_Pu and the practical stability
limit ζ_prac = K_Pu α K / (2ω_n), ω_n² / (α K) to find the limit at a given ω_n.
Source: Maeda 2007, sec. 3.1.4, eq. 3-14.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.leadscrew import compensator as nct_compensator
from controllers.leadscrew import nominal_trajectory as nct_element
from controllers.leadscrew.nominal_trajectory import POINTS, Input
from fmus.model import FloatArray, Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0
    element: nct_element.State = nct_element.State()
    compensator: nct_compensator.State = nct_compensator.State()


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]
    e: Annotated[float, Var("mm", "position error")]
    K_p: Annotated[float, Var("A.s/mm", "proportional gain on this stair")]


class Parameters(NamedTuple):
    e_nct: Annotated[
        FloatArray, Var("mm", "errors of the trajectory, ascending", fixed=True)
    ] = np.linspace(0.0, 1.0, POINTS)
    edot_nct: Annotated[
        FloatArray, Var("mm/s", "error rates of the trajectory", fixed=True)
    ] = np.linspace(0.0, 16.5, POINTS)
    K_p1: Annotated[float, Var("A.s/mm", "gain on the first stair", min=0)] = 1.5
    q: Annotated[float, Var("1", "ratio of two stairs", min=1)] = 1.02
    T_d: Annotated[float, Var("s", "duration of a stair", min=1e-9)] = 0.5
    K_i: Annotated[float, Var("A/mm", "integral gain")] = 0.0
    u_s: Annotated[float, Var("A", "where the actuator saturates", min=0)] = 6.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Run the NCTF law with the gain of this stair."""
    n = np.floor(x.k / tick_of(p.T_d, T_s))
    K_p = p.K_p1 * p.q**n
    x_element, element = nct_element.step(
        x.element, u, nct_element.Parameters(p.e_nct, p.edot_nct, False), T_s
    )
    x_compensator, compensator = nct_compensator.step(
        x.compensator,
        nct_compensator.Input(element.u_p),
        nct_compensator.Parameters(K_p, p.K_i, p.u_s, True),
        T_s,
    )
    x_next = State(x.k + 1, x_element, x_compensator)
    return x_next, Output(compensator.u, element.e, K_p)


model = Sampled(
    "NCTFGainStairs",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
