"""Integrator that stands still while it would drive the actuator further into
saturation (conditional freeze).

    Δu_i = 0 if |u_o + u_i| > u_s and Δ u_i >= 0, else Δ;    u_i⁺ = u_i + T_s Δu_i

Source: Maeda 2007, eq. 3-16; its e is the integrator's input Δ.
"""

from typing import Any

import numpy as np


def integrated(u_i: Any, rate: Any, u_o: Any, u_s: Any, on: Any, T_s: Any) -> Any:
    """Return the integral one sample on; ``rate`` is Δ (A/s), u_o the rest of u."""
    saturated = np.logical_and(np.abs(u_o + u_i) > u_s, rate * u_i >= 0)
    frozen = np.logical_and(on, saturated)
    return u_i + np.where(frozen, 0.0, T_s * rate)
