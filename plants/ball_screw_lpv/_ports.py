"""Signals of every plant of this drive, all along the table's travel.

u_c grows towards the thrust bearing: x_c = x_0 - u_c.

Source: Hanifzadegan 2014, fig. 3.4; x_c = 650 mm - r of sec. 4.5.2.
"""

from typing import Annotated, NamedTuple

from fmus.model import Var


class Input(NamedTuple):
    """Command, forces and what the dynamics vary with."""

    v_m: Annotated[float, Var("V", "command to the amplifier")] = 0.0
    f_m: Annotated[float, Var("N", "further force on the motor side")] = 0.0
    f_c: Annotated[float, Var("N", "external force on the table")] = 0.0
    x_c: Annotated[float, Var("m", "nut distance from the thrust bearing", min=0)] = 0.4
    m_wor: Annotated[float, Var("kg", "mass of the workpiece", min=0)] = 0.0


class Output(NamedTuple):
    """Both positions, and the nut distance that the table position means."""

    u_m: Annotated[float, Var("m", "motor position as table travel")]
    u_c: Annotated[float, Var("m", "table position")]
    x_n: Annotated[float, Var("m", "nut distance at this table position")]
    v: Annotated[float, Var("m/s", "speed that friction acts on")]
