"""Averaged MIMO controller of the gantry: the whole controller in one sample.

    y_1f, y_2f = prefilter(y_r),    α_i, M_y scheduled by x_s
    u = h · averaging(y_if - y_im) + M_y (a_yr, a_yr) + u_d

The parts are models of their own; here they run one after the other at the same
instant.
Source: Gordon 2010, sec. 4.4.2, fig. 4.10, eq. 4.30 to 4.33.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

from controllers.filters import linear_prefilter
from controllers.filters._sections import First
from controllers.gantry import _common
from controllers.gantry import averaging as gantry_averaging
from controllers.gantry import feedforward as gantry_feedforward
from controllers.gantry import filters as gantry_filters
from controllers.gantry import prefilter as gantry_prefilter
from controllers.gantry._common import Coefficients, Common, Input, Output, settings
from fmus.model import Sampled, Var


class State(NamedTuple):
    prefilter: linear_prefilter.State = linear_prefilter.State()
    feedback: gantry_averaging.State = gantry_averaging.State()
    filters: gantry_filters.State = gantry_filters.State()


class Parameters(NamedTuple):
    K: Annotated[float, Var("V/m", "gain on the averaged error")] = 116158.8004
    T_d: Annotated[float, Var("s", "lead time", min=1e-9)] = 0.004709660418
    a: Annotated[float, Var("rad/s", "pole of the lead", min=1e-9)] = 669.3477867
    beta: Annotated[float, Var("V.s/m", "active damping")] = 49.03546478
    k_i: Annotated[float, Var("V/(m.s)", "integral gain of either end")] = 1e7
    m: Annotated[float, Var("V.s2/m", "mass of gantry and table", min=1e-9)] = 2.722
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=0)] = 0.6977
    L: Annotated[float, Var("m", "distance of the motors", min=1e-9)] = 1.484
    J_0: Annotated[float, Var("V.m.s2/rad", "inertia without table", min=0)] = 0.4342
    d: Annotated[float, Var("m", "table's lever at x = 0")] = 0.1655
    alpha_0: Annotated[float, Var("1", "offset of the mass distribution")] = 0.0
    prefilter: gantry_prefilter.Parameters = gantry_prefilter.Parameters()
    feedforward: gantry_feedforward.Parameters = gantry_feedforward.Parameters()
    filters: gantry_filters.Parameters = gantry_filters.Parameters()


class Derived(NamedTuple):
    feedback: First
    common: Coefficients


def of_feedback(p: Parameters) -> gantry_averaging.Parameters:
    """Return the law's own parameters."""
    return gantry_averaging.Parameters(p.K, p.T_d, p.a, p.beta, p.k_i)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match every part at the sample time."""
    feedback = gantry_averaging.prepare(of_feedback(p), T_s)
    return Derived(feedback, _common.prepare(settings(p), T_s))


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""

    def law(e: gantry_averaging.Input) -> tuple[Any, gantry_averaging.Output]:
        return gantry_averaging.step(x.feedback, e, of_feedback(p), T_s, d.feedback)

    common = Common(x.prefilter, x.filters)
    after, feedback, y = _common.around(law, common, u, settings(p), T_s, d.common)
    return State(after.prefilter, feedback, after.filters), y


model = Sampled(
    "GantryMIMO",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
