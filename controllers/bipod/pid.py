"""PID controller scaled by the inertia, a baseline without synthesis.

    f_1 = H_1(φ) (K_p e + K_i Σ T_s e + K_d Δe/T_s)
    K_p = ω_c²/2,    K_d = ω_c,    K_i = ω_c³/10

The gains are our choice; the source has no such controller.
Source: Hanifzadegan 2014, eq. 7.8 (H_1).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.bipod._law import Inertia, Input, Output, force
from fmus.model import Sampled, Var


class State(NamedTuple):
    i: Annotated[float, Var("m.s", "integral of the error", nominal=1e-6)] = 0.0
    e_1: Annotated[float, Var("m", "previous error", nominal=1e-5)] = 0.0


class Gains(NamedTuple):
    """Gains by one crossover frequency."""

    omega_c: Annotated[float, Var("rad/s", "crossover frequency", min=0)] = 400.0


class Parameters(NamedTuple):
    gains: Gains = Gains()
    inertia: Inertia = Inertia()


def acceleration(x: State, e: float, p: Gains, T_s: float) -> tuple[State, float]:
    """Return the next state and ν (m/s²) at the error e (m)."""
    i = x.i + T_s * e
    rate = (e - x.e_1) / T_s
    nu = p.omega_c**2 / 2 * e + p.omega_c**3 / 10 * i + p.omega_c * rate
    return State(i, e), nu


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the force of this sample."""
    e = u.r - u.x_1
    x_next, nu = acceleration(x, e, p.gains, T_s)
    return x_next, Output(force(nu, u.phi, p.inertia), e)


model = Sampled(
    "BipodPID", step, State(), Input(), Parameters(), period=Fraction(1, 2000)
)
