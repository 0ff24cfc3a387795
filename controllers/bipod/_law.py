"""What every controller of slider T1 takes and gives, and its force from ν.

    f_1 = H_1(φ) ν - G(φ),    H_1 = h_0 + h_1 tan²φ,    G = -½ m_h g tan φ

The designs are for ν, an acceleration.  g = 0 as in the source, whose f_1 - G is the
control signal.  Source: Hanifzadegan 2014, eq. 7.8, 7.11 and fig. 7.13.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Input(NamedTuple):
    """Command, slider, and what the dynamics vary with."""

    r: Annotated[float, Var("m", "command to slider T1")] = 0.0
    x_1: Annotated[float, Var("m", "position of slider T1")] = 0.0
    v_1: Annotated[float, Var("m/s", "its speed")] = 0.0
    phi: Annotated[
        float, Var("rad", "angle of the rods", min=-1.57, max=1.57, nominal=0.3)
    ] = 0.17453292519943295


class Output(NamedTuple):
    """The force and the error."""

    f_1: Annotated[float, Var("N", "force on slider T1")]
    e: Annotated[float, Var("m", "error")]


class Inertia(NamedTuple):
    """What the controller knows of the mechanism (Table 7.1)."""

    h_0: Annotated[float, Var("kg", "inertia at φ = 0", min=0)] = 33.50632653061225
    h_1: Annotated[float, Var("kg", "its growth with tan²φ", min=0)] = 3.986326530612245
    m_h: Annotated[float, Var("kg", "mass that hangs on the rods", min=0)] = 16.8
    g: Annotated[float, Var("m/s2", "gravity that is compensated")] = 0.0


def force(nu: Any, phi: Any, p: Inertia) -> Any:
    """Return f_1 (N) for the acceleration ν (m/s²)."""
    t = np.tan(phi)
    return (p.h_0 + p.h_1 * t * t) * nu - p.m_h * p.g * t / 2
