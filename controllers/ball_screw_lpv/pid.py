"""PID controller with a filtered derivative, the source's baseline.

    v_m = (K_p + K_i/s + K_d s/(s/ω_f + 1)) (r - u_c)

by Tustin's rule.  The printed K_p = 5e5 V/m without a filter is unstable on the
drive's flexible mode; a tenth of it with ω_f = 400 rad/s is our choice.
Source: Hanifzadegan 2014, sec. 4.4.3 (5e5, 3e6, 120 without units).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    i: Annotated[float, Var("m.s", "integral of the error", nominal=1e-6)] = 0.0
    d: Annotated[float, Var("m/s", "filtered rate of the error", nominal=1e-3)] = 0.0
    e_1: Annotated[float, Var("m", "previous error", nominal=1e-5)] = 0.0


class Input(NamedTuple):
    r: Annotated[float, Var("m", "table command")] = 0.0
    u_c: Annotated[float, Var("m", "table position")] = 0.0


class Output(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")]
    e: Annotated[float, Var("m", "error")]


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("V/m", "proportional gain")] = 5e4
    K_i: Annotated[float, Var("V/(m.s)", "integral gain")] = 3e6
    K_d: Annotated[float, Var("V.s/m", "derivative gain")] = 120.0
    omega_f: Annotated[float, Var("rad/s", "pole of the derivative", min=1e-3)] = 400.0


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the command of this sample."""
    e = u.r - u.u_c
    i = x.i + T_s / 2 * (e + x.e_1)
    w = p.omega_f * T_s
    d = ((2 - w) * x.d + 2 * p.omega_f * (e - x.e_1)) / (2 + w)
    return State(i, d, e), Output(p.K_p * e + p.K_i * i + p.K_d * d, e)


model = Sampled("PID", step, State(), Input(), Parameters(), period=Fraction(9, 25_000))
