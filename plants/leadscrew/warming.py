"""Leadscrew axis whose friction falls as it warms up.

    ẇ = (P / P_1 - w) / τ,    P = T_fric θ̇ + C_sd θ̇²
    T_c(w) = T_c (1 - a_c w),    C_sd(w) = C_sd (1 - a_v w)

w is 1 in the long run at the friction's power P_1.  The axis is
``plants.leadscrew.axis``; with a_c = a_v = 0 it is that.
Source: Maeda 2007, sec. 3.3 and 4.5: 40 s of a sine of 20 mm at 0.6 Hz lower Coulomb
and viscous friction by 13 and 24 % (Y), 12 and 26 % (X).  The law, P_1 and τ are ours.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Included, Var
from plants.leadscrew import axis
from plants.leadscrew.axis import Input


class State(NamedTuple):
    screw: Annotated[axis.State, Included()] = axis.State()
    warmth: Annotated[float, Var("1", "warmth w", min=0)] = 0.0


class Output(NamedTuple):
    x: Annotated[float, Var("m", "table position")]
    v: Annotated[float, Var("m/s", "table speed")]
    omega: Annotated[float, Var("rad/s", "rotor speed")]
    i: Annotated[float, Var("A", "motor current")]
    w: Annotated[float, Var("1", "warmth")]
    T_c_now: Annotated[float, Var("N.m", "Coulomb friction at this warmth")]
    C_sd_now: Annotated[float, Var("N.m.s/rad", "viscous friction at this warmth")]


class Parameters(NamedTuple):
    screw: Annotated[axis.Parameters, Included()] = axis.Parameters()
    a_c: Annotated[float, Var("1", "share of T_c that warmth takes", min=0)] = 0.15
    a_v: Annotated[float, Var("1", "share of C_sd that warmth takes", min=0)] = 0.28
    P_1: Annotated[float, Var("W", "power of the friction for w = 1", min=1e-9)] = 30.0
    tau: Annotated[float, Var("s", "time constant of the warmth", min=1e-9)] = 20.0


def at(w: Any, p: Parameters) -> axis.Parameters:
    """Return the axis at warmth w; friction does not become negative."""
    T_c = p.screw.T_c * np.maximum(1 - p.a_c * w, 0.0)
    C_sd = p.screw.C_sd * np.maximum(1 - p.a_v * w, 0.0)
    return p.screw._replace(T_c=T_c, C_sd=C_sd)


def heating(x: State, p: Parameters) -> Any:
    """Return ẇ (1/s)."""
    now = at(x.warmth, p)
    T_fric = now.sigma_0 * x.screw.z + now.sigma_1 * axis.rate(x.screw, now)
    power = (T_fric + now.C_sd * x.screw.omega) * x.screw.omega
    return (power / p.P_1 - x.warmth) / p.tau


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    return State(axis.derivative(x.screw, u, at(x.warmth, p)), heating(x, p))


def advance(x: State, u: Input, p: Parameters, h: float) -> State:
    """One step of the axis at this warmth, which changes by Euler's rule: slowly."""
    screw = axis.advance(x.screw, u, at(x.warmth, p), h)
    warmth = np.maximum(x.warmth + h * heating(x, p), 0.0)
    return State(screw, warmth)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return what the axis does, and how warm it is."""
    now = at(x.warmth, p)
    y = axis.output(x.screw, u, p.screw)
    return Output(y.x, y.v, y.omega, y.i, x.warmth, now.T_c, now.C_sd)


model = Continuous(
    "WarmingLeadscrew",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    advance=advance,
)
