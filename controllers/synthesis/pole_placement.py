"""Poles that compensate the mode of a drive with one axial compliance.

The axial pair keeps its imaginary part and is damped by the factor β; the rigid
mode and the integrator get a pair and a real pole at f_2:

    p_1,2 = -β σ_1 ± j ω_d1,  p_3,4 = ω_2 (-ζ_2 ± j √(1 - ζ_2²)),  p_5 = -ω_2

Source: Gordon 2010, equations 3.5 to 3.7 (ω_2 is 2π·50 rad/s; the text prints Hz).
"""

import numpy as np
from numpy.typing import NDArray


def closed_loop_poles(
    open_loop: NDArray[np.complex128], beta: float, f2_hz: float, zeta_2: float
) -> NDArray[np.complex128]:
    """Return the five wanted poles (rad/s) from those of the plant.

    Raises:
        ValueError: the plant has no oscillating mode.
    """
    axial = open_loop[np.argmax(open_loop.imag)]
    if axial.imag <= 0:
        raise ValueError(
            f"no oscillating axial mode among the poles {np.sort(open_loop.real)}: "
            f"mode compensation needs c small enough for one"
        )
    sigma_1, omega_d1 = -axial.real, axial.imag
    omega_2 = 2 * np.pi * f2_hz
    p_1 = -beta * sigma_1 + 1j * omega_d1
    p_3 = omega_2 * (-zeta_2 + 1j * np.sqrt(1 - zeta_2**2))
    pairs = np.array([p_1, p_3])
    return np.concatenate([pairs, pairs.conj(), [-omega_2]])
