"""Curves of the XY table's frequency-domain figures, as arrays over omega.

Parameters by name as in ``controllers.synthesis.xy_table.loops``.
Source: Anang et al. 2018, figures 3, 4, 8 and 9.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from controllers.synthesis.xy_table.loops import Cascade
from controllers.xy_table.position_np import nonlinear_gain

Curves: TypeAlias = dict[str, NDArray[Any]]


def loops(lowest: float = 1.0, highest: float = 3000.0, **parameters: Any) -> Curves:
    """Return omega (n,) (rad/s) and complex ``speed``, ``position`` and ``popov``.

    The first two are the open loops (eq. 2, 3); ``popov`` is Re G + j ω Im G of the
    position loop, the plane of fig. 8.

    Raises:
        LookupError: no parameter of plant or controller of that name.
    """
    omega = np.geomspace(lowest, highest, 3000)
    found = Cascade(**parameters).loops(omega)
    L = found.position
    return {
        "omega": omega,
        "speed": found.speed,
        "position": L,
        "popov": L.real + 1j * omega * L.imag,
    }


def nonlinear(KO: float = 3.5, e_max: float = 0.5) -> Curves:
    """Return errors ``e`` (mm) up to e_max and the gain ``K_e`` there (eq. 5)."""
    e = np.linspace(-e_max, e_max, 201)
    K_e = [float(nonlinear_gain(float(one), KO, e_max)) for one in e]
    return {"e": e, "K_e": np.array(K_e, dtype=float)}
