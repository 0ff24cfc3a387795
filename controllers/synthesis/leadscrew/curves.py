"""Curves of the leadscrew study's figures that are computed, as arrays.

Source: Maeda 2007, figures 3-5 to 3-7 and 4-6.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from controllers.synthesis.jury import is_stable
from controllers.synthesis.leadscrew.stability import closed_loop, practical_limit

Curves: TypeAlias = dict[str, NDArray[Any]]
ONE_POLE = np.array([1.0, -1.0])  # z - 1


def linear_limit(alpha_T: float = 0.101, integral: bool = True) -> Curves:
    """Return omega_n_T (rad) and the largest stable ``zeta`` by Jury's test.

    Args:
        alpha_T: inclination of the trajectory times sample time.
        integral: the compensator integrates.
    """

    def stable(omega_n_T: float, zeta: float) -> bool:
        found = closed_loop(alpha_T, omega_n_T, zeta, integral=integral)
        if not integral:  # the integrator's own pole is no part of the loop
            found = np.polydiv(found, ONE_POLE)[0]
        return is_stable(found)

    def limit(omega_n_T: float) -> float:
        low, high = 0.0, 1e3
        zetas = np.geomspace(1e-2, high, 60)
        found = [zeta for zeta in zetas if stable(omega_n_T, zeta)]
        if not found:
            return float("nan")
        low, high = found[-1], min(high, found[-1] * zetas[1] / zetas[0])
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (middle, high) if stable(omega_n_T, middle) else (low, middle)
        return float(low)

    omega = np.geomspace(0.02, 0.4, 15)
    return {"omega_n_T": omega, "zeta": np.array([limit(float(one)) for one in omega])}


def practical(K_pu: float = 2.4, share: float = 1.0) -> Curves:
    """Return omega_n_T (rad) and ``zeta``, a share of the practical limit (eq. 3-14).

    Args:
        K_pu: ultimate proportional gain (A s/mm).
        share: 1 less the margin of safety.
    """
    omega = np.geomspace(0.02, 0.4, 100)
    zeta = [share * practical_limit(K_pu, float(one)) for one in omega]
    return {"omega_n_T": omega, "zeta": np.array(zeta)}


def filters(zeta: float, frequency_hz: float = 215.0) -> Curves:
    """Return f_hz and the complex ``low_pass`` and ``notch`` of eq. 4-1.

    Args:
        zeta: damping ratio of both.
        frequency_hz: natural frequency (Hz).
    """
    f_hz = np.geomspace(1.0, 1000.0, 1501)
    s = 1j * f_hz / frequency_hz  # over the natural frequency
    below = s * s + 2 * zeta * s + 1
    return {
        "f_hz": f_hz,
        "low_pass": np.asarray(1 / below),
        "notch": np.asarray((s * s + 1) / below),
    }
