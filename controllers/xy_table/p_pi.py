"""Cascade P/PI of an XY table: the whole controller in one sample.

    e = z_ref - y,    v_ref = (k_v g) e,    u = k_p e_v + k_i ∫e_v,  e_v = v_ref - V_est

g is 1 but in gain tests.
Source: Anang et al. 2018, fig. 2, eq. 2, 3.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.filters._sections import LowPass
from controllers.xy_table import velocity_estimator
from controllers.xy_table._cascade import Input, Output, State, control
from fmus.model import Sampled, Var


class Parameters(NamedTuple):
    k_v: Annotated[float, Var("1/s", "position gain")] = 225.0
    k_p: Annotated[float, Var("V.s/mm", "proportional gain")] = 0.006607
    k_i: Annotated[float, Var("V/mm", "integral gain")] = 0.12075
    estimator: velocity_estimator.Parameters = velocity_estimator.Parameters()


def prepare(p: Parameters, T_s: float) -> LowPass:
    """Match the estimator's low-pass at the sample time."""
    return velocity_estimator.prepare(p.estimator, T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Return the control signal of this sample."""
    e = u.z_ref - u.y
    return control(x, u, e, (p.k_v * u.g) * e, p, T_s, d)


model = Sampled(
    "PPICascade",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
    prepare=prepare,
)
