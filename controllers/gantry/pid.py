"""Independent PID controllers of the gantry: the whole baseline in one sample.

    u = h_p · PID(y_if - y_im) + M_y (a_yr, a_yr) + u_d

h_p are the notches and the low-pass of the averaged controller without its lead;
schedule, pre-filter and feed-forward are the same.
Source: Gordon 2010, sec. 4.4.2, 4.5 (named there; structure and gains are ours).
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

from controllers.filters import linear_prefilter
from controllers.gantry import _common
from controllers.gantry import averaging as gantry_averaging
from controllers.gantry import end_pid as gantry_end_pid
from controllers.gantry import feedforward as gantry_feedforward
from controllers.gantry import filters as gantry_filters
from controllers.gantry import prefilter as gantry_prefilter
from controllers.gantry._common import Coefficients, Common, Input, Output, settings
from fmus.model import Sampled, Var


class State(NamedTuple):
    prefilter: linear_prefilter.State = linear_prefilter.State()
    feedback: gantry_end_pid.State = gantry_end_pid.State()
    filters: gantry_filters.State = gantry_filters.State()


class Parameters(NamedTuple):
    K_p: Annotated[float, Var("V/m", "proportional gain")] = 15869.0
    K_i: Annotated[float, Var("V/(m.s)", "integral gain")] = 247953.0
    K_d: Annotated[float, Var("V.s/m", "derivative gain")] = 253.904
    m: Annotated[float, Var("V.s2/m", "mass of gantry and table", min=1e-9)] = 2.722
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=0)] = 0.6977
    L: Annotated[float, Var("m", "distance of the motors", min=1e-9)] = 1.484
    J_0: Annotated[float, Var("V.m.s2/rad", "inertia without table", min=0)] = 0.4342
    d: Annotated[float, Var("m", "table's lever at x = 0")] = 0.1655
    alpha_0: Annotated[float, Var("1", "offset of the mass distribution")] = 0.0
    prefilter: gantry_prefilter.Parameters = gantry_prefilter.Parameters()
    feedforward: gantry_feedforward.Parameters = gantry_feedforward.Parameters()
    filters: gantry_filters.Parameters = gantry_filters.Parameters(lead_on=False)


def prepare(p: Parameters, T_s: float) -> Coefficients:
    """Match every part at the sample time."""
    return _common.prepare(settings(p), T_s)


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Coefficients
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""

    def law(e: gantry_averaging.Input) -> tuple[Any, gantry_averaging.Output]:
        gains = gantry_end_pid.Parameters(p.K_p, p.K_i, p.K_d)
        return gantry_end_pid.step(x.feedback, e, gains, T_s)

    common = Common(x.prefilter, x.filters)
    after, feedback, y = _common.around(law, common, u, settings(p), T_s, d)
    return State(after.prefilter, feedback, after.filters), y


model = Sampled(
    "GantryPID",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
