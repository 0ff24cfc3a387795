"""Stribeck friction of the screw, as a function of its speed.

    d(v) = tanh(v / v_s) (d_c + (d_s - d_c) exp(-|v| / Ω))

with own values for either direction.  The tanh makes the jump of the source's
law at v = 0 continuous.  The values are not published; these are our choice.
Source: Gordon 2010, eq. 2.1.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Stribeck(NamedTuple):
    """Parameters of the law; all four levels are magnitudes."""

    on: Annotated[bool, Var("1", "friction acts")] = False
    d_c_plus: Annotated[float, Var("V", "Coulomb friction, v > 0", min=0)] = 0.12
    d_c_minus: Annotated[float, Var("V", "Coulomb friction, v < 0", min=0)] = 0.12
    d_s_plus: Annotated[float, Var("V", "static friction, v > 0", min=0)] = 0.20
    d_s_minus: Annotated[float, Var("V", "static friction, v < 0", min=0)] = 0.20
    Omega: Annotated[float, Var("rad/s", "velocity constant", min=1e-9)] = 2.0
    v_s: Annotated[float, Var("rad/s", "regularisation speed", min=1e-9)] = 0.05


def friction(v: Any, p: Stribeck) -> Any:
    """Return the friction torque (V) that opposes the speed v (rad/s)."""
    d_c: Any = np.where(v >= 0, p.d_c_plus, p.d_c_minus)
    d_s: Any = np.where(v >= 0, p.d_s_plus, p.d_s_minus)
    level = d_c + (d_s - d_c) * np.exp(-np.abs(v) / p.Omega)
    return np.where(p.on, np.tanh(v / p.v_s) * level, 0.0)
