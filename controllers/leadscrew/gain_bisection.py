"""Ultimate gain by bisection: NCTF control that halves the interval of its K_p.

    K_p = √(K_low K_high),   every T_d:   oscillated?  K_high = K_p : K_low = K_p

A trial begins with a rest of T_r, current off and memories cleared, so that an
oscillation that a higher gain has left does not live on; it oscillates if the current
of its last tail T_t spans more than ``span``.  After N trials the interval is
(K_high/K_low)^{2^-N}.  With K_i = 0 it ends at K_Pu, with ω_n² / (α K) at the limit at
that ω_n.
Source: Maeda 2007, sec. 3.1.4 (the gain is raised until oscillations show); bisection
in the place of raising is ours.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.leadscrew import compensator as nct_compensator
from controllers.leadscrew import nominal_trajectory as nct_element
from controllers.leadscrew.nominal_trajectory import POINTS, Input
from fmus.model import FloatArray, Sampled, Var
from fmus.ticks import tick_of


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the trial began")] = 0.0
    low: Annotated[float, Var("A.s/mm", "highest gain known stable")] = 0.0
    high: Annotated[float, Var("A.s/mm", "lowest gain known unstable")] = 0.0
    least: Annotated[float, Var("A", "lowest current in this tail")] = 0.0
    most: Annotated[float, Var("A", "highest current in this tail")] = 0.0
    element: nct_element.State = nct_element.State()
    compensator: nct_compensator.State = nct_compensator.State()


class Output(NamedTuple):
    u: Annotated[float, Var("A", "current command")]
    e: Annotated[float, Var("mm", "position error")]
    K_p: Annotated[float, Var("A.s/mm", "proportional gain of this trial")]
    K_stable: Annotated[float, Var("A.s/mm", "highest gain known stable")]
    K_unstable: Annotated[float, Var("A.s/mm", "lowest gain known unstable")]


class Parameters(NamedTuple):
    e_nct: Annotated[
        FloatArray, Var("mm", "errors of the trajectory, ascending", fixed=True)
    ] = np.linspace(0.0, 1.0, POINTS)
    edot_nct: Annotated[
        FloatArray, Var("mm/s", "error rates of the trajectory", fixed=True)
    ] = np.linspace(0.0, 16.5, POINTS)
    K_low: Annotated[float, Var("A.s/mm", "a stable gain", min=1e-9)] = 0.5
    K_high: Annotated[float, Var("A.s/mm", "an unstable gain", min=1e-9)] = 8.0
    T_d: Annotated[float, Var("s", "duration of a trial", min=1e-9)] = 0.5
    T_r: Annotated[float, Var("s", "its rest at the beginning", min=0)] = 0.1
    T_t: Annotated[float, Var("s", "its tail that is judged", min=1e-9)] = 0.1
    span: Annotated[float, Var("A", "more is an oscillation", min=0)] = 0.5
    K_i: Annotated[float, Var("A/mm", "integral gain")] = 0.0
    u_s: Annotated[float, Var("A", "where the actuator saturates", min=0)] = 6.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Run the NCTF law with the gain of this trial."""
    low: Any = np.where(x.low > 0, x.low, p.K_low)
    high: Any = np.where(x.high > 0, x.high, p.K_high)
    K_p: Any = np.sqrt(low * high)
    resting = x.k < tick_of(p.T_r, T_s)
    x_element, element = nct_element.step(
        x.element, u, nct_element.Parameters(p.e_nct, p.edot_nct, False), T_s
    )
    x_compensator, compensator = nct_compensator.step(
        x.compensator,
        nct_compensator.Input(element.u_p),
        nct_compensator.Parameters(K_p, p.K_i, p.u_s, True),
        T_s,
    )
    u_now: Any = np.where(resting, 0.0, compensator.u)
    u_i: Any = np.where(resting, 0.0, x_compensator.u_i)

    left = tick_of(p.T_d, T_s) - x.k  # samples of this trial from here on
    first = left >= tick_of(p.T_t, T_s)
    least: Any = np.where(first, u_now, np.minimum(x.least, u_now))
    most: Any = np.where(first, u_now, np.maximum(x.most, u_now))
    over = left <= 1
    oscillates = most - least > p.span
    k: Any = np.where(over, 0.0, x.k + 1)
    lower: Any = np.where(np.logical_and(over, np.logical_not(oscillates)), K_p, low)
    upper: Any = np.where(np.logical_and(over, oscillates), K_p, high)
    held = nct_compensator.State(u_i)
    x_next = State(k, lower, upper, least, most, x_element, held)
    return x_next, Output(u_now, element.e, K_p, low, high)


model = Sampled(
    "NCTFGainBisection",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 5_000),
)
