"""The two-mass ball screw as a supplier might ship it: other names, mm, other sign.

Source: none; a test of the swap (2026).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var
from plants.ball_screw import two_mass as ball_screw

PER_RAD = 20 / (2 * 3.141592653589793)  # mm of table motion per rad of the screw


class State(NamedTuple):
    drive: ball_screw.State = ball_screw.State()


class Input(NamedTuple):
    motor_voltage: Annotated[float, Var("V", "drives the table backwards")] = 0.0
    table_force: Annotated[float, Var("V", "disturbance on the table")] = 0.0


class Output(NamedTuple):
    screw: Annotated[float, Var("mm", "screw position as table motion")]
    table: Annotated[float, Var("mm", "table position")]


class Parameters(NamedTuple):
    drive: ball_screw.Parameters = ball_screw.Parameters()


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the derivative of the drive with its own sign."""
    inner = ball_screw.Input(-u.motor_voltage, 0.0, u.table_force)
    return State(ball_screw.derivative(x.drive, inner, p.drive))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return both positions in millimetres."""
    return Output(PER_RAD * x.drive.x_1, PER_RAD * x.drive.x_2)


model = Continuous("Disguised", derivative, output, State(), Input(), Parameters())
