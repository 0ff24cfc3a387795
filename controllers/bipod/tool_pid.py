"""Both sliders controlled so that the tool table follows a path.

    cos φ_r = y_r/L_s,    x_1r, x_2r = x_r ∓ (a_s/2 + L_s sin φ_r)
    (f_1, f_2) = [H_1 H_12; H_12 H_2](φ) (ν_1, ν_2)

with a PID controller of ``pid`` for either slider.  A command beyond the reach of the
rods is held at its edge.
Source: Hanifzadegan 2014, fig. 7.11, eq. 7.6 to 7.8; the controller is our choice.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from controllers.bipod import pid
from controllers.bipod._law import Inertia
from fmus.model import Sampled, Var


class State(NamedTuple):
    first: pid.State = pid.State()
    second: pid.State = pid.State()


class Input(NamedTuple):
    x_r: Annotated[float, Var("m", "command along the rail")] = 0.43
    y_r: Annotated[float, Var("m", "command from the rail")] = 0.5
    x_1: Annotated[float, Var("m", "position of slider T1")] = 0.0
    x_2: Annotated[float, Var("m", "position of slider T2")] = 0.86


class Output(NamedTuple):
    f_1: Annotated[float, Var("N", "force on slider T1")]
    f_2: Annotated[float, Var("N", "force on slider T2")]
    e_1: Annotated[float, Var("m", "error of slider T1")]
    e_2: Annotated[float, Var("m", "error of slider T2")]


class Parameters(NamedTuple):
    gains: pid.Gains = pid.Gains()
    inertia: Inertia = Inertia()
    h_2: Annotated[float, Var("kg", "inertia of T2 at φ = 0", min=0)] = (
        28.736326530612246
    )
    h_12: Annotated[float, Var("kg", "coupling of both at φ = 0")] = 4.4136734693877555
    L_s: Annotated[float, Var("m", "length of the rods", min=1e-3)] = 0.7
    a_s: Annotated[float, Var("m", "offset of the joints")] = 0.125


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return both forces of this sample."""
    cosine = np.minimum(np.maximum(u.y_r / p.L_s, 0.0), 1.0)
    half = p.a_s / 2 + p.L_s * np.sqrt(1 - cosine * cosine)
    e_1, e_2 = u.x_r - half - u.x_1, u.x_r + half - u.x_2
    first, nu_1 = pid.acceleration(x.first, e_1, p.gains, T_s)
    second, nu_2 = pid.acceleration(x.second, e_2, p.gains, T_s)
    sine = (u.x_2 - u.x_1 - p.a_s) / (2 * p.L_s)
    square = sine * sine
    h = p.inertia.h_1 * square / np.maximum(1 - square, 1e-4)
    weight = (
        p.inertia.m_h * p.inertia.g / 2 * sine / np.sqrt(np.maximum(1 - square, 1e-4))
    )
    f_1 = (p.inertia.h_0 + h) * nu_1 + (p.h_12 - h) * nu_2 - weight
    f_2 = (p.h_12 - h) * nu_1 + (p.h_2 + h) * nu_2 + weight
    return State(first, second), Output(f_1, f_2, e_1, e_2)


model = Sampled(
    "BipodToolPID", step, State(), Input(), Parameters(), period=Fraction(1, 2000)
)
