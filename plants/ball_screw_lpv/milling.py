"""Cutting force of half-immersion milling with a helical end mill.

    φ_j(z) = φ + 2πj/N - k_β z,   φ = 2π n t,   k_β = 2 tan β / D,   φ_st <= φ_j <= φ_ex
    dF_t = (K_te + K_tc c sin φ_j) dz,      dF_r = (K_re + K_rc c sin φ_j) dz
    dF_x = -dF_t cos φ_j - dF_r sin φ_j,    dF_y = dF_t sin φ_j - dF_r cos φ_j
    F = √(F_x² + F_y²),   f = -F   while t_on <= t < t_off

integrated in closed form over the engaged arc of each tooth; up milling enters at 0
and leaves at π/2 (the defaults), down milling from π/2 to π.
Source: Hanifzadegan 2014, sec. 4.5.2, Table 4.2 (edge constants are N/mm; printed
N/mm²), after Altintas, Manufacturing Automation, 2000, p. 40.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Sampled, Var
from fmus.ticks import tick_of, turn

TEETH = 4


class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks since the start")] = 0.0


class Input(NamedTuple):
    """The force follows the clock alone."""


class Output(NamedTuple):
    f: Annotated[float, Var("N", "disturbance on the drive")]
    F: Annotated[float, Var("N", "resultant force")]
    F_x: Annotated[float, Var("N", "force along the feed")]
    F_y: Annotated[float, Var("N", "force across the feed")]


class Parameters(NamedTuple):
    n_hz: Annotated[float, Var("Hz", "spindle speed", min=0)] = 3400 / 60
    depth: Annotated[float, Var("m", "depth of cut", min=0)] = 2.7e-3
    c: Annotated[float, Var("m", "feed per tooth", min=0)] = 1e-4
    D: Annotated[float, Var("m", "diameter of the tool", min=1e-6)] = 18e-3
    beta: Annotated[float, Var("rad", "helix angle", min=1e-6, max=1.5)] = np.pi / 6
    K_tc: Annotated[float, Var("Pa", "tangential cutting constant", min=0)] = 1.980e9
    K_rc: Annotated[float, Var("Pa", "radial cutting constant", min=0)] = 0.540e9
    K_te: Annotated[float, Var("N/m", "tangential edge constant", min=0)] = 35e3
    K_re: Annotated[float, Var("N/m", "radial edge constant", min=0)] = 30e3
    phi_st: Annotated[float, Var("rad", "a tooth enters", min=0, max=np.pi)] = 0.0
    phi_ex: Annotated[float, Var("rad", "a tooth leaves", min=0, max=np.pi)] = np.pi / 2
    t_on: Annotated[float, Var("s", "the cut begins", min=0)] = 0.0
    t_off: Annotated[float, Var("s", "the cut ends", min=0)] = 1e6


def tooth(phi: Any, p: Parameters) -> tuple[Any, Any]:
    """Return F_x and F_y of the tooth whose tip stands at phi, in [0, 2π)."""
    k_beta = 2 * np.tan(p.beta) / p.D
    high = np.minimum(np.maximum(phi, p.phi_st), p.phi_ex)
    low = np.minimum(np.maximum(phi - k_beta * p.depth, p.phi_st), p.phi_ex)

    def integral(phi: Any) -> tuple[Any, Any]:
        across = np.sin(phi) ** 2 / 2
        along = phi / 2 - np.sin(2 * phi) / 4
        F_x = -p.K_te * np.sin(phi) - p.K_tc * p.c * across
        F_x = F_x + p.K_re * np.cos(phi) - p.K_rc * p.c * along
        F_y = -p.K_te * np.cos(phi) + p.K_tc * p.c * along
        F_y = F_y - p.K_re * np.sin(phi) - p.K_rc * p.c * across
        return F_x, F_y

    (x_1, y_1), (x_0, y_0) = integral(high), integral(low)
    return (x_1 - x_0) / k_beta, (y_1 - y_0) / k_beta


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the force of this sample."""
    turned = turn(p.n_hz, x.k, T_s)
    F_x: Any = 0.0
    F_y: Any = 0.0
    for j in range(TEETH):
        at = turned + j / TEETH
        x_j, y_j = tooth(2 * np.pi * (at - np.floor(at)), p)
        F_x, F_y = F_x + x_j, F_y + y_j
    F = np.sqrt(F_x * F_x + F_y * F_y)
    entered = x.k >= tick_of(p.t_on, T_s)
    cutting = np.logical_and(entered, x.k < tick_of(p.t_off, T_s))
    f: Any = np.where(cutting, -F, 0.0)
    return State(x.k + 1), Output(f, F, F_x, F_y)


model = Sampled(
    "MillingForce", step, State(), Input(), Parameters(), period=Fraction(3, 50_000)
)
