"""Friction tables compared with the mechanism, and updated where they are wrong.

The displacement by a fixed pulse is looked up (``friction_lookup``), the model moves
with that friction beside the mechanism, both runs are compared.  Where they are apart
the friction is measured from the run itself (``friction_motion``) and becomes the
table's entry at that displacement; entries within ``NEAR`` of it are replaced.
Source: Maeda 2007, appendix, fig. A-1 (steps 4 to 6 and "need to be updated").
"""

from typing import NamedTuple

import numpy as np

from controllers.synthesis.leadscrew import friction_lookup, friction_motion
from fmus.model import FloatArray

NEAR = 0.3  # mm: entries of one condition


class Tables(NamedTuple):
    """Displacement (mm, ascending), viscous (N m s/rad), Coulomb friction (N m)."""

    displacement: FloatArray
    viscous: FloatArray
    coulomb: FloatArray


def apart(x: FloatArray, x_model: FloatArray) -> float:
    """Return the largest distance (m) of two runs (n,) at the same instants."""
    return float(np.max(np.abs(np.asarray(x) - np.asarray(x_model))))


def updated(tables: Tables, d: float, C_sd: float, T_c: float) -> Tables:
    """Return the tables with one condition measured anew, at d (mm)."""
    kept = np.abs(tables.displacement - d) > NEAR
    columns = zip(tables, (d, C_sd, T_c), strict=True)
    joined = [np.append(np.asarray(old)[kept], new) for old, new in columns]
    order = np.argsort(joined[0])
    return Tables(*(column[order] for column in joined))


def compare_and_update(
    x: FloatArray,
    x_model: FloatArray,
    i: FloatArray,
    T_s: float,
    read_at: float,
    displacement: FloatArray,
    viscous: FloatArray,
    coulomb: FloatArray,
    J: float,
    M: float,
    lead: float,
    C_sd: float,
    T_c: float,
    tolerance: float = 0.2e-3,
) -> dict[str, float]:
    """Return the friction of the tables, updated if the model is not the mechanism.

    Args:
        x, x_model: mechanism and model under the same pulse (m), (n,).
        i: current of the mechanism (A), (n,).
        T_s: sample time (s).
        read_at: when the displacement is read (s).
        displacement, viscous, coulomb: the tables, as for ``friction_lookup``.
        J, M, lead: as for ``friction_motion.friction``.
        C_sd, T_c: the friction known so far, kept if the mechanism was not driven.
        tolerance: largest distance of the runs that is a match (m).

    Returns:
        C_sd (N m s/rad) and T_c (N m).

    Raises:
        ValueError: the runs match, but the displacement lies outside the tables.
    """
    d = 1e3 * abs(float(x[round(read_at / T_s)] - x[0]))
    if d < friction_lookup.DRIVEN:
        return {"C_sd": C_sd, "T_c": T_c}
    tables = Tables(displacement, viscous, coulomb)
    if apart(x, x_model) > tolerance:
        found = friction_motion.friction(x, i, T_s, J, M, lead)
        tables = updated(tables, d, found["C_sd"], found["T_c"])
    return friction_lookup.at_displacement(d, *tables)
