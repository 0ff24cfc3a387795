"""What drives the screw: the amplifier as a gain, and Coulomb friction.

    f = (k_t k_a v_m - T_f)/r_g + f_m,      T_f = T± tanh(v/v_0)

Source: Hanifzadegan 2014, eq. 3.22 (repaired) and 3.23, Tables 3.1 and 3.2; v_0 is
our choice, as a true sign would need the logic of sticking.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Amplifier(NamedTuple):
    """Current loop as its DC gain, which it keeps within 12 % below 1000 rad/s."""

    k_a: Annotated[float, Var("A/V", "gain of the current loop", min=0)] = 0.887
    k_t: Annotated[float, Var("N.m/A", "torque constant")] = 0.72


class Friction(NamedTuple):
    """Coulomb friction at the motor (Table 3.2)."""

    on: Annotated[bool, Var("1", "friction acts")] = True
    T_plus: Annotated[float, Var("N.m", "torque in positive motion", min=0)] = 0.3686
    T_minus: Annotated[float, Var("N.m", "torque in negative motion", max=0)] = -0.2551
    v_0: Annotated[float, Var("m/s", "speed of the transition", min=1e-9)] = 1e-3


def friction_torque(v: Any, p: Friction) -> Any:
    """Return T_f (N m) at the table speed v (m/s)."""
    size: Any = np.where(v > 0, p.T_plus, -p.T_minus)
    return p.on * size * np.tanh(v / p.v_0)


def motor_force(
    v_m: Any, f_m: Any, v: Any, amplifier: Amplifier, friction: Friction, r_g: Any
) -> Any:
    """Return the force on the motor side (N) at command v_m (V) and speed v (m/s)."""
    torque = amplifier.k_t * amplifier.k_a * v_m - friction_torque(v, friction)
    return torque / r_g + f_m
