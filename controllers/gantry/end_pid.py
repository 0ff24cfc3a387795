"""Independent PID controllers of the two ends: what averaging is compared with.

    v_i = α_i (K_p + K_i/s + K_d s) (y_if - y_im)

s is a backward difference, 1/s the trapezoidal rule.
Source: Gordon 2010, sec. 4.4.2, 4.5 (named there; structure and gains are ours).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

from controllers.gantry.averaging import Input, Output
from fmus.model import Sampled, Var


class State(NamedTuple):
    e_1: Annotated[float, Var("m", "previous left error")] = 0.0
    e_2: Annotated[float, Var("m", "previous right error")] = 0.0
    e_1i: Annotated[float, Var("m.s", "integral of the left error")] = 0.0
    e_2i: Annotated[float, Var("m.s", "integral of the right error")] = 0.0


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("V/m", "proportional gain")] = 15869.0
    K_i: Annotated[float, Var("V/(m.s)", "integral gain")] = 247953.0
    K_d: Annotated[float, Var("V.s/m", "derivative gain")] = 253.904


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return both feedback signals of this sample."""
    e_1, e_2 = u.y_1f - u.y_1m, u.y_2f - u.y_2m
    v_1, e_1i = pid(e_1, x.e_1, x.e_1i, p, T_s)
    v_2, e_2i = pid(e_2, x.e_2, x.e_2i, p, T_s)
    return State(e_1, e_2, e_1i, e_2i), Output(u.alpha_1 * v_1, u.alpha_2 * v_2)


def pid(e: Any, before: Any, e_i: Any, p: Parameters, T_s: Any) -> tuple[Any, Any]:
    """Return the signal of one end and the next integral of its error."""
    half = T_s / 2 * e
    rate = (e - before) / T_s
    return p.K_p * e + p.K_i * (e_i + half) + p.K_d * rate, e_i + half + half


model = Sampled(
    "GantryEndPID",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
)
