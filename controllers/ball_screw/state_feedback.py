"""State feedback with integral action: the mode-compensating pole placement.

    e_1 = x_1r - y_1,   e_2 = x_2r - y_2
    v = K_x1 e_1 + K_x2 e_2 + K_v1 D e_1 + K_v2 D e_2 + K_i2 ∫e_2

D e[k] = (e[k] - e[k-1]) / T_s; the integral is that of backward rectangles.
Source: Gordon 2010, eq. 3.5 to 3.8; default gains for β = 4, ω_2 = 50 Hz, ζ_2 = 0.7.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    e_1: Annotated[float, Var("rad", "previous screw error")] = 0.0
    e_2: Annotated[float, Var("rad", "previous table error")] = 0.0
    e_i2: Annotated[float, Var("rad.s", "integral of the table error")] = 0.0


class Input(NamedTuple):
    x_1r: Annotated[float, Var("rad", "screw command")] = 0.0
    x_2r: Annotated[float, Var("rad", "table command as screw angle")] = 0.0
    y_1: Annotated[float, Var("rad", "rotary encoder")] = 0.0
    y_2: Annotated[float, Var("rad", "linear encoder as screw angle")] = 0.0


class Output(NamedTuple):
    v: Annotated[float, Var("V", "feedback signal")]


class Parameters(NamedTuple):
    K_x1: Annotated[float, Var("V/rad", "gain on the screw error")] = 632.965300
    K_x2: Annotated[float, Var("V/rad", "gain on the table error")] = -83.312458
    K_v1: Annotated[float, Var("V.s/rad", "gain on the screw error rate")] = 1.648469979
    K_v2: Annotated[float, Var("V.s/rad", "gain on the table error rate")] = 0.264903101
    K_i2: Annotated[float, Var("V/(rad.s)", "gain on the integral")] = 70135.3877


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the errors to remember and the feedback signal."""
    e_1 = u.x_1r - u.y_1
    e_2 = u.x_2r - u.y_2
    e_i2 = x.e_i2 + T_s * e_2
    v = (
        p.K_x1 * e_1
        + p.K_x2 * e_2
        + p.K_v1 * (e_1 - x.e_1) / T_s
        + p.K_v2 * (e_2 - x.e_2) / T_s
        + p.K_i2 * e_i2
    )
    return State(e_1, e_2, e_i2), Output(v)


model = Sampled(
    "StateFeedback",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
)
