"""The drive's parameters as the controllers know them, declared once.

Whole controllers and their parts include these records.
"""

from typing import Annotated, NamedTuple

from fmus.model import Var


class TwoMass(NamedTuple):
    """Screw and table with the axial compliance between them."""

    m_1: Annotated[float, Var("V.s2/rad", "rotating inertia", min=1e-9)] = 1.858e-3
    m_2: Annotated[float, Var("V.s2/rad", "translating inertia", min=1e-9)] = 0.379e-3
    b_1: Annotated[float, Var("V.s/rad", "damping of motor and bearings", min=0)] = (
        1.020e-3
    )
    b_2: Annotated[float, Var("V.s/rad", "damping of the guideways", min=0)] = 0.0
    k: Annotated[float, Var("V/rad", "axial stiffness", min=1e-9)] = 210.02
    c: Annotated[float, Var("V.s/rad", "damping of the nut", min=0)] = 0.014


class Rigid(NamedTuple):
    """Screw and table as one body; nothing is divided by an inertia."""

    m_1: Annotated[float, Var("V.s2/rad", "rotating inertia", min=0)] = 1.858e-3
    m_2: Annotated[float, Var("V.s2/rad", "translating inertia", min=0)] = 0.379e-3
    b_1: Annotated[float, Var("V.s/rad", "damping of motor and bearings", min=0)] = (
        1.020e-3
    )
    b_2: Annotated[float, Var("V.s/rad", "damping of the guideways", min=0)] = 0.0
