"""Run-time form of gain-scheduled controllers: sampled systems of one scalar y.

    (x⁺, u) = K(ρ) (x, y),     K = [A B; C D]

A design is a file of JSON beside the model; what a controller reads of it is

    period       "9/25000", the sample time (s) that the matrices are made for
    A, B, C, D   (..., r, r), (..., r, 1), (..., 1, r), (..., 1, 1), one for each
                 breakpoint of ρ, which stand in the file under their own names

All points share one state, so matrices may be interpolated (``fmus.table``).  Where
regions have controllers of their own, ``region`` switches with hysteresis, and
``bumpless`` moves the state so that u does not jump.
Source: Hanifzadegan 2014, eq. 4.11 and 6.6, sec. 5.1.1; the source only says "reset".
"""

import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from fmus.model import FloatArray


def system(design: Mapping[str, Any]) -> FloatArray:
    """Return the matrices K of a design, one below the other."""
    A, B, C, D = (np.array(design[name], dtype=float) for name in "ABCD")
    whole = np.concatenate(
        [np.concatenate([A, B], axis=-1), np.concatenate([C, D], axis=-1)], axis=-2
    )
    return np.asarray(whole.reshape(-1, whole.shape[-1]))


def period(file: bytes) -> Fraction:
    """Return the sample time of a design (s)."""
    return Fraction(json.loads(file)["period"])


def run(K: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return x⁺ and u of K at state x (r,) and a scalar y."""
    r = K.shape[1] - 1
    z = K[:, :r] @ x + K[:, r] * y
    return z[:r], z[r]


def region(before: Any, rho: Any, rho_12: Any, rho_21: Any) -> Any:
    """Return region 1 or 2: 2 from ``rho_12`` upwards, 1 from ``rho_21`` downwards.

    Between the two it stays as ``before``, of which 0 means none yet: then 1.
    """
    first = np.logical_or(before < 1.5, rho <= rho_21)
    held: Any = np.where(first, 1.0, 2.0)
    return np.where(rho >= rho_12, 2.0, held)


def bumpless(K: Any, x: Any, y: Any, u: Any) -> Any:
    """Return the state nearest to x at which K answers y with u.

    x + C'(CC')⁻¹(u - Cx - Dy); C must not vanish.
    """
    r = K.shape[1] - 1
    C = K[r, :r].T
    missing = u - np.dot(C, x) - K[r, r] * y
    return x + C * (missing / np.dot(C, C))
