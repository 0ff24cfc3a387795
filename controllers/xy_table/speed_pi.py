"""Speed loop of the cascades P/PI and NP/PI.

    e_v = v_ref - v_est,    u = k_p e_v + k_i ∫e_v

The integral is that of backward rectangles; no limit is published.
Source: Anang et al. 2018, sec. 3.1, fig. 2.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from fmus.model import Sampled, Var


class State(NamedTuple):
    e_vi: Annotated[float, Var("mm", "integral of the velocity error")] = 0.0


class Input(NamedTuple):
    v_ref: Annotated[float, Var("mm/s", "velocity reference")] = 0.0
    v_est: Annotated[float, Var("mm/s", "estimated velocity")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]


class Parameters(NamedTuple):
    k_p: Annotated[float, Var("V.s/mm", "proportional gain")] = 0.006607
    k_i: Annotated[float, Var("V/mm", "integral gain")] = 0.12075


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    """Return the control signal of this sample."""
    e_v = u.v_ref - u.v_est
    e_vi = x.e_vi + T_s * e_v
    return State(e_vi), Output(p.k_p * e_v + p.k_i * e_vi)


model = Sampled(
    "SpeedPI",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
)
