"""Leadscrew axis whose table rubs on its guide, with a static level at the rotor.

    J θ̈ = K_m i - T_fric - C_sd θ̇ - r F,    M ẍ = F - F_fric
    T_fric with the level T_c + (T_s - T_c) e^{-(θ̇/ω_s)²} for T_c
    ẇ = ẋ - σ_0g |ẋ| w / F_g,    F_fric = σ_0g w + σ_1g ẇ

The bristle w of the guide is the rotor's, in the table's motion.  With F_g = 0 and
T_s = T_c this is ``plants.leadscrew.axis``.
Source: Maeda 2007, fig. 2-3 (friction at the rotor alone); Canudas de Wit et al.
1995 (static level).  What the guide takes is not published: second edition, ours.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Included, Var, add
from plants.leadscrew import axis
from plants.leadscrew._lugre import TINY, bristle, slip
from plants.leadscrew.axis import Input, Output


class State(NamedTuple):
    screw: Annotated[axis.State, Included()] = axis.State()
    w: Annotated[float, Var("m", "bristle of the guide", nominal=1e-7)] = 0.0


class Parameters(NamedTuple):
    screw: Annotated[axis.Parameters, Included()] = axis.Parameters()
    T_s: Annotated[float, Var("N.m", "static friction of the rotor", min=0)] = 0.046
    omega_s: Annotated[float, Var("rad/s", "speed where it fades", min=1e-9)] = 5.0
    F_g: Annotated[float, Var("N", "friction of the guide", min=0)] = 60.0
    sigma_0g: Annotated[float, Var("N/m", "its presliding stiffness", min=1e-9)] = 6e7
    sigma_1g: Annotated[float, Var("N.s/m", "its presliding damping", min=0)] = 1e4


def level(omega: Any, p: Parameters) -> Any:
    """Return what the rotor's bristle carries at this speed (N.m)."""
    excess = p.T_s - p.screw.T_c
    return p.screw.T_c + excess * np.exp(-((omega / p.omega_s) ** 2))


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    rotor = p.screw._replace(T_c=level(x.screw.omega, p))
    k = axis.derivative(x.screw, u, rotor)
    rate = slip(x.w, x.screw.v, p.F_g, p.sigma_0g) * x.screw.v
    guide: Any = np.where(p.F_g > 0, p.sigma_0g * x.w + p.sigma_1g * rate, 0.0)
    return State(k._replace(v=k.v - guide / p.screw.M), rate)


def advance(x: State, u: Input, p: Parameters, h: float) -> State:
    """Fourth order between kinks: the rotor's first, and where the table reverses."""
    k = derivative(x, u, p).screw
    rotor = axis.time_to_kink(x.screw, u, k.omega, p.screw, h)
    turn: Any = -x.screw.v / np.where(k.v == 0, TINY, k.v)
    table = np.where(turn > 0, np.minimum(turn, h), h)
    first, second = np.minimum(rotor, table), np.maximum(rotor, table)
    for part in (first, second - first, h - second):
        x = along(x, u, p, part)
    return x


def along(x: State, u: Input, p: Parameters, h: Any) -> State:
    """Return the state h later by Runge-Kutta 4, both bristles exact in the motion."""

    def ahead(h: Any, k: State) -> State:
        z = bristle(
            x.screw.z, h * k.screw.theta, level(k.screw.theta, p), p.screw.sigma_0
        )
        w = bristle(x.w, h * k.screw.x, p.F_g, p.sigma_0g)
        held: Any = np.where(p.F_g > 0, w, 0.0)
        return State(add(x, [(h, k)]).screw._replace(z=z), held)

    k_1 = derivative(x, u, p)
    k_2 = derivative(ahead(h / 2, k_1), u, p)
    k_3 = derivative(ahead(h / 2, k_2), u, p)
    k_4 = derivative(ahead(h, k_3), u, p)
    changes = [(-5 / 6, k_1), (1 / 3, k_2), (1 / 3, k_3), (1 / 6, k_4)]
    return ahead(h, add(k_1, changes))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the table's motion, the rotor's speed and the current."""
    return axis.output(x.screw, u, p.screw)


model = Continuous(
    "GuidedLeadscrew",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    advance=advance,
)
