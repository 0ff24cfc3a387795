"""What every whole controller of the ball-screw drive reads and returns.

One record for all of them, so that one can take the other's place in a system.
"""

from typing import Annotated, NamedTuple

from fmus.model import Var


class Input(NamedTuple):
    x_r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    v_r: Annotated[float, Var("rad/s", "commanded velocity")] = 0.0
    a_r: Annotated[float, Var("rad/s2", "commanded acceleration")] = 0.0
    j_r: Annotated[float, Var("rad/s3", "commanded jerk")] = 0.0
    s_r: Annotated[float, Var("rad/s4", "commanded snap")] = 0.0
    y_1: Annotated[float, Var("rad", "rotary encoder")] = 0.0
    y_2: Annotated[float, Var("rad", "linear encoder as screw angle")] = 0.0
    u_d: Annotated[float, Var("V", "excitation or further feed-forward")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]
    u_ff: Annotated[float, Var("V", "feed-forward of the drive's dynamics")]
    x_f: Annotated[float, Var("rad", "pre-filtered command x_r'")]


class Rotary(NamedTuple):
    on: Annotated[bool, Var("1", "rotary command generator acts")] = True


class Inversion(NamedTuple):
    on: Annotated[bool, Var("1", "feed-forward of the drive's dynamics acts")] = True
