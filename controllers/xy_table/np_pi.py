"""Cascade NP/PI of an XY table: the whole controller in one sample.

    e = z_ref - y,    v_ref = (k_v N g) e,    N = cosh(KO e),    |e| <= e_max in N
    u = k_p e_v + k_i ∫e_v,    e_v = v_ref - V_est

KO = 0 is ``controllers.xy_table.p_pi`` to the last bit; g is 1 but in gain tests.
Source: Anang et al. 2018, fig. 7, eq. 5, table 1.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.filters._sections import LowPass
from controllers.xy_table import position_np as np_position
from controllers.xy_table import velocity_estimator
from controllers.xy_table._cascade import Input, Output, State, control
from fmus.model import Sampled, Var


class Parameters(NamedTuple):
    k_v: Annotated[float, Var("1/s", "position gain")] = 225.0
    KO: Annotated[
        float, Var("1/mm", "rate of variation of the nonlinear gain", min=0)
    ] = 3.5
    e_max: Annotated[float, Var("mm", "error beyond which N is held", min=0)] = 0.5
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
    _, position = np_position.step(
        np_position.State(),
        np_position.Input(u.z_ref, u.y, u.g),
        np_position.Parameters(p.k_v, p.KO, p.e_max),
        T_s,
    )
    return control(x, u, position.e, position.v_ref, p, T_s, d)


model = Sampled(
    "NPPI",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 2000),
    prepare=prepare,
)
