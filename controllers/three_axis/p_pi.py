"""Cascade P-PI of the x and y axes, the baseline without synthesis.

    v_r = K_p (r - u_c),   e_v = v_r - Δu_c/T_s,   I⁺ = I + T_s/T_i e_v
    v_m = K_v (e_v + I⁺)

A controller that starts away from 0 starts with its last positions there.
Source: ours; Hanifzadegan 2014 has no cascade on this machine.  The gains are our
choice.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    I_x: Annotated[float, Var("m/s", "integral part, x")] = 0.0
    I_y: Annotated[float, Var("m/s", "integral part, y")] = 0.0
    u_cx_1: Annotated[float, Var("m", "last position, x", nominal=0.01)] = 0.0
    u_cy_1: Annotated[float, Var("m", "last position, y", nominal=0.01)] = 0.0


class Input(NamedTuple):
    r_x: Annotated[float, Var("m", "command, x")] = 0.0
    r_y: Annotated[float, Var("m", "command, y")] = 0.0
    u_cx: Annotated[float, Var("m", "table position, x")] = 0.0
    u_cy: Annotated[float, Var("m", "table position, y")] = 0.0


class Output(NamedTuple):
    v_mx: Annotated[float, Var("V", "command to x")]
    v_my: Annotated[float, Var("V", "command to y")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("1/s", "position gain")] = 20.0
    K_vx: Annotated[float, Var("V.s/m", "velocity gain, x")] = 100.0
    K_vy: Annotated[float, Var("V.s/m", "velocity gain, y")] = 50.0
    T_i: Annotated[float, Var("s", "integral time", min=1e-9)] = 0.05


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the commands of this sample."""
    I_x, v_mx = _axis(x.I_x, x.u_cx_1, u.r_x, u.u_cx, p.K_vx, p, T_s)
    I_y, v_my = _axis(x.I_y, x.u_cy_1, u.r_y, u.u_cy, p.K_vy, p, T_s)
    return State(I_x, I_y, u.u_cx, u.u_cy), Output(v_mx, v_my)


def _axis(
    i: Any, last: Any, r: Any, u_c: Any, K_v: Any, p: Parameters, T_s: float
) -> tuple[Any, Any]:
    e_v = p.K_p * (r - u_c) - (u_c - last) / T_s
    i_next = i + T_s / p.T_i * e_v
    return i_next, K_v * (e_v + i_next)


model = Sampled(
    "PlanarPPI", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
