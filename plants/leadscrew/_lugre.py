"""Presliding friction of one rotating axis: LuGre with Coulomb friction only.

    ż = ω - σ_0 |ω| z / T_c,     T = σ_0 z + σ_1 ż

A bristle of deflection z carries the torque; sliding at constant speed gives T_c.
Source: Canudas de Wit et al. 1995 (Maeda 2007, ref. 4), with equal static and
Coulomb level.
"""

from typing import Any

import numpy as np

TINY = 1e-300


def slip(z: Any, omega: Any, T_c: Any, sigma_0: Any) -> Any:
    """Return g of ż = g ω: 1 at rest without load, 0 sliding, 2 just reversed.

    Without friction (T_c = 0) there is no bristle to deflect: 0.
    """
    g = 1 - sigma_0 * z * np.sign(omega) / np.maximum(T_c, TINY)
    return np.where(T_c > 0, g, 0.0)


def bristle(z: Any, turned: Any, T_c: Any, sigma_0: Any) -> Any:
    """Return z after an angle (rad) turned one way: exact, at any speed and stiffness.

    dz/dθ = 1 - σ_0 z sign(ω) / T_c holds no time.
    """
    z_ss = np.sign(turned) * T_c / sigma_0
    return z_ss + (z - z_ss) * np.exp(-sigma_0 * np.abs(turned) / np.maximum(T_c, TINY))
