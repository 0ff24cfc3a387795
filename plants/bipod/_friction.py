"""Coulomb friction of a slider on its rail.

    f = F_c tanh(v/v_0)

The source has viscous friction only; size and v_0 are our choice, off unless asked
for.  Source: Hanifzadegan 2014, eq. 3.23, there for the ball screw.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Friction(NamedTuple):
    """Parameters of the law, one for all sliders."""

    on: Annotated[bool, Var("1", "friction acts")] = False
    F_c: Annotated[float, Var("N", "force while sliding", min=0)] = 30.0
    v_0: Annotated[float, Var("m/s", "speed of the transition", min=1e-9)] = 1e-3


def friction(v: Any, p: Friction) -> Any:
    """Return the force (N) against the speed v (m/s)."""
    return p.on * p.F_c * np.tanh(v / p.v_0)
