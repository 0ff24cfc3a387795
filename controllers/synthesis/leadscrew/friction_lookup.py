"""Friction read off one open-loop displacement (fast friction measurement).

A fixed pulse moves the mechanism; how far it goes tells its friction by tables of
conditions that were identified once.  Between them a shape-preserving cubic.
Source: Maeda 2007, appendix (prints "pcchip" for pchip).
"""

import numpy as np
from scipy.interpolate import PchipInterpolator

from fmus.model import FloatArray

DRIVEN = 5.0  # mm: less means that the amplifier was off


def identify(
    x: FloatArray,
    T_s: float,
    read_at: float,
    displacement: FloatArray,
    viscous: FloatArray,
    coulomb: FloatArray,
    C_sd: float,
    T_c: float,
) -> dict[str, float]:
    """Return the friction that explains a displacement.

    Args:
        x: position of the open-loop run (m), shape (n,), from rest at 0.
        T_s: time between two of its values (s).
        read_at: when the displacement is read (s).
        displacement: of the tabled conditions (mm), ascending, shape (m,).
        viscous, coulomb: their friction (N m s/rad, N m), shape (m,).
        C_sd, T_c: the friction known so far, kept if the mechanism was not driven.

    Returns:
        C_sd (N m s/rad) and T_c (N m).

    Raises:
        ValueError: the displacement lies outside the tables.
    """
    d = 1e3 * abs(float(x[round(read_at / T_s)] - x[0]))
    if d < DRIVEN:
        return {"C_sd": C_sd, "T_c": T_c}
    return at_displacement(d, displacement, viscous, coulomb)


def at_displacement(
    d: float, displacement: FloatArray, viscous: FloatArray, coulomb: FloatArray
) -> dict[str, float]:
    """Return the friction at a displacement d (mm); the tables as for ``identify``.

    Raises:
        ValueError: d lies outside the tables.
    """
    low, high = float(displacement[0]), float(displacement[-1])
    if not low <= d <= high:
        raise ValueError(f"{d:.4g} mm lies outside the tables, {low:g} to {high:g} mm")
    tables = np.column_stack([viscous, coulomb])
    C_sd, T_c = PchipInterpolator(displacement, tables)(d)
    return {"C_sd": float(C_sd), "T_c": float(T_c)}
