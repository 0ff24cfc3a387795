"""Tables of sampled systems over the nut distance, and over the workpiece's mass.

    (x⁺, u) = [A B; C D](ρ) (x, y),   linear between the table's points, held beyond

A design's breakpoints are ``x_c`` (m), (n,), and where it is scheduled ``m_wor``
(kg), (k,); its matrices those of ``controllers._scheduled``, (n, ...) or (n, k, ...).
Source: Hanifzadegan 2014, eq. 4.11: X is constant, all points share one state.
"""

import json
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers._scheduled import system
from fmus.model import FloatArray, Var
from fmus.table import lookup_rows, slopes


class Table(NamedTuple):
    """Systems at nut distances, one matrix [A B; C D] below the other."""

    x_c: Annotated[
        FloatArray, Var("m", "nut distances of the table", fixed=True, min=0)
    ]
    K: Annotated[FloatArray, Var("1", "[A B; C D] at each of them", fixed=True)]


class TableOfMass(NamedTuple):
    """Systems at nut distances and, for each, at masses of the workpiece."""

    x_c: Annotated[
        FloatArray, Var("m", "nut distances of the table", fixed=True, min=0)
    ]
    m_wor: Annotated[FloatArray, Var("kg", "masses of the table", fixed=True, min=0)]
    K: Annotated[FloatArray, Var("1", "[A B; C D] at each of them", fixed=True)]


class Slopes(NamedTuple):
    """Of the matrices over the nut distance."""

    K: Any


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


def prepare(p: Table | TableOfMass) -> Slopes:
    """Return the slopes over the nut distance."""
    return Slopes(slopes(p.x_c, p.K))


def at(x_c: Any, p: Table, d: Slopes) -> Any:
    """Return [A B; C D] at a nut distance x_c (m)."""
    return lookup_rows(x_c, p.x_c, p.K, d.K)


def at_mass(x_c: Any, m_wor: Any, p: TableOfMass, d: Slopes) -> Any:
    """Return [A B; C D] at a nut distance x_c (m) and a mass m_wor (kg)."""
    return lookup_rows(m_wor, p.m_wor, lookup_rows(x_c, p.x_c, p.K, d.K))
