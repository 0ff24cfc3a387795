"""Run-time form of a gain-scheduled controller: a table of sampled systems.

    (x⁺, u) = [A B; C D](ρ) (x, y),   linear between the table's points, held beyond

All points share one state, as X is constant in the design (Hanifzadegan 2014, eq.
4.11), so matrices may be interpolated.  A design is a file of JSON beside the model;
what the controller reads of it is

    period        "9/25000", the sample time (s) that the matrices are made for
    x_c, m_wor    breakpoints (m, kg), (n,) and (k,); m_wor only where it is scheduled
    A, B, C, D    (n, r, r), (n, r, 1), (n, 1, r), (n, 1, 1); with m_wor (n, k, ...)
"""

import json
from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import FloatArray, Var
from fmus.table import lookup_rows, slopes


class Table(NamedTuple):
    """Systems at nut distances, one matrix [A B; C D] below the other."""

    x_c: Annotated[FloatArray, Var("m", "nut distances of the table", fixed=True)]
    K: Annotated[FloatArray, Var("1", "[A B; C D] at each of them", fixed=True)]


class TableOfMass(NamedTuple):
    """Systems at nut distances and, for each, at masses of the workpiece."""

    x_c: Annotated[FloatArray, Var("m", "nut distances of the table", fixed=True)]
    m_wor: Annotated[FloatArray, Var("kg", "masses of the table", fixed=True)]
    K: Annotated[FloatArray, Var("1", "[A B; C D] at each of them", fixed=True)]


class Slopes(NamedTuple):
    """Of the matrices over the nut distance."""

    K: Any


def system(design: Any) -> FloatArray:
    """Return the matrices [A B; C D] of a design, one below the other."""
    A, B, C, D = (np.array(design[name], dtype=float) for name in "ABCD")
    whole = np.concatenate(
        [np.concatenate([A, B], axis=-1), np.concatenate([C, D], axis=-1)], axis=-2
    )
    return np.asarray(whole.reshape(-1, whole.shape[-1]))


def table(file: bytes) -> Table:
    """Return the table in a file of JSON."""
    design = json.loads(file)
    return Table(np.array(design["x_c"]), system(design))


def table_of_mass(file: bytes) -> TableOfMass:
    """Return the table over position and mass in a file of JSON."""
    design = json.loads(file)
    return TableOfMass(
        np.array(design["x_c"]), np.array(design["m_wor"]), system(design)
    )


def period(file: bytes) -> Fraction:
    """Return the sample time of a design (s)."""
    return Fraction(json.loads(file)["period"])


def prepare(p: Table | TableOfMass) -> Slopes:
    """Return the slopes over the nut distance."""
    return Slopes(slopes(p.x_c, p.K))


def at(x_c: Any, p: Table, d: Slopes) -> Any:
    """Return [A B; C D] at a nut distance x_c (m)."""
    return lookup_rows(x_c, p.x_c, p.K, d.K)


def at_mass(x_c: Any, m_wor: Any, p: TableOfMass, d: Slopes) -> Any:
    """Return [A B; C D] at a nut distance x_c (m) and a mass m_wor (kg)."""
    return lookup_rows(m_wor, p.m_wor, lookup_rows(x_c, p.x_c, p.K, d.K))


def run(K: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return x⁺ and u of [A B; C D] at state x (r,) and a scalar y."""
    r = K.shape[1] - 1
    z = K[:, :r] @ x + K[:, r] * y
    return z[:r], z[r]
