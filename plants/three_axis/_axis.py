"""One axis: the motor with its inertia, and the flexible factor to the table.

    v̇ = (p_t/2π (k_t k_a v_m - T_f) + (p_t/2π)² f_c - B_e v)/J_e
    ż = Λ z + b v,      u̇_c = c z,      T_f = T_c tanh(v/v_0)

v is the screw's speed as table speed.  Λ holds the modes in real blocks: σ on its
diagonal, ω above and -ω below it, 0 between blocks; c (sI - Λ)⁻¹ b is G_flex of
Table 8.2 (tests/plants/test_three_axis.py).  f_c enters at the motor: its own transfer
function is not identified.  Friction is not in the source's model and off unless
asked for; its values are our choice.
Source: Hanifzadegan 2014, eq. 8.18 to 8.21, Tables 8.1 and 8.2.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import FloatArray, Var


class State(NamedTuple):
    u_c: Annotated[float, Var("m", "table position", nominal=0.01)]
    v: Annotated[float, Var("m/s", "screw speed as table speed", nominal=0.1)]
    z: Annotated[FloatArray, Var("m", "flexible modes", nominal=1e-4)]


class Friction(NamedTuple):
    """Coulomb friction at the motor; on an axis 0.3 N m are about 0.1 V."""

    on: Annotated[bool, Var("1", "friction acts")] = False
    T_c: Annotated[float, Var("N.m", "its torque", min=0)] = 0.3
    v_0: Annotated[float, Var("m/s", "speed of the transition", min=1e-9)] = 1e-3


class Axis(NamedTuple):
    """Rigid body (Table 8.1) and flexible factor (Table 8.2)."""

    k_a: Annotated[float, Var("A/V", "gain of the amplifier", min=0)]
    p_t: Annotated[float, Var("m", "pitch: travel per turn", min=1e-9)]
    J_e: Annotated[float, Var("kg.m2", "inertia at the motor", min=1e-9)]
    B_e: Annotated[float, Var("N.m.s/rad", "viscous damping", min=0)]
    sigma: Annotated[FloatArray, Var("1/s", "diagonal of the modes")]
    omega: Annotated[FloatArray, Var("1/s", "beside the diagonal")]
    b: Annotated[FloatArray, Var("1", "how v drives the modes")]
    c: Annotated[FloatArray, Var("1/s", "what the modes give to the table's speed")]
    k_t: Annotated[float, Var("N.m/A", "torque constant")] = 0.4769
    friction: Friction = Friction()


def at_rest(p: Axis) -> State:
    """Return the state of an axis that rests at 0."""
    return State(0.0, 0.0, np.zeros(len(p.sigma)))


def derivative(x: State, v_m: Any, f_c: Any, p: Axis) -> State:
    """Return ẋ at command v_m (V) and force on the table f_c (N)."""
    r_g = p.p_t / (2 * np.pi)
    T_f = p.friction.on * p.friction.T_c * np.tanh(x.v / p.friction.v_0)
    torque = p.k_t * p.k_a * v_m - T_f + r_g * f_c
    v_dot = (r_g * torque - p.B_e * x.v) / p.J_e
    end = np.zeros(1)
    above = np.concatenate([p.omega * x.z[1:], end])
    below = np.concatenate([end, p.omega * x.z[:-1]])
    z_dot = p.sigma * x.z + above - below + p.b * x.v
    return State(np.dot(p.c, x.z), v_dot, z_dot)
