"""Whole controller of the x axis in one sample.

    x_f = prefilter(x_r)
    u   = filters(double_lead(x_f - x_m)) + m_x a_xr + u_d

The parts are models of their own; here they run one after the other at the same
instant.
Source: Gordon 2010, sec. 4.4.1, eq. 4.17 to 4.20.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.filters import linear_prefilter
from controllers.filters import prefilter as pre_filter
from controllers.filters._sections import LowPass
from controllers.gantry import double_lead, mass_feedforward
from controllers.gantry import x_filters as gantry_x_filters
from fmus.model import Included, Sampled, Var


class State(NamedTuple):
    prefilter: linear_prefilter.State = linear_prefilter.State()
    feedback: double_lead.State = double_lead.State()
    filters: gantry_x_filters.State = gantry_x_filters.State()


class Input(NamedTuple):
    x_r: Annotated[float, Var("m", "command")] = 0.0
    a_xr: Annotated[float, Var("m/s2", "commanded acceleration")] = 0.0
    x_m: Annotated[float, Var("m", "reading of the table")] = 0.0
    u_d: Annotated[float, Var("V", "excitation or further feed-forward")] = 0.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]
    u_ff: Annotated[float, Var("V", "feed-forward")]
    x_f: Annotated[float, Var("m", "pre-filtered command x_r'")]


class Feedforward(NamedTuple):
    on: Annotated[bool, Var("1", "inertia feed-forward acts")] = True


class Parameters(NamedTuple):
    K: Annotated[float, Var("V/(m.s)", "gain")] = 6345303.494
    T_i: Annotated[float, Var("s", "reset time", min=1e-9)] = 0.006943173348
    T_d: Annotated[float, Var("s", "lead time of either lead", min=1e-9)] = (
        0.005099446522
    )
    a: Annotated[float, Var("rad/s", "pole of either lead", min=1e-9)] = 3402.275541
    m_x: Annotated[float, Var("V.s2/m", "mass of the table", min=0)] = 0.6977
    pre: Annotated[pre_filter.Gains, Included()] = pre_filter.Gains()
    feedforward: Feedforward = Feedforward()
    filters: gantry_x_filters.Parameters = gantry_x_filters.Parameters()


class Derived(NamedTuple):
    prefilter: LowPass
    feedback: double_lead.Derived
    filters: gantry_x_filters.Derived


def of_prefilter(p: Parameters) -> pre_filter.Parameters:
    """Return the pre-filter's own parameters."""
    return pre_filter.Parameters(*p.pre)


def of_feedback(p: Parameters) -> double_lead.Parameters:
    """Return the compensator's own parameters."""
    return double_lead.Parameters(p.K, p.T_i, p.T_d, p.a)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match every part at the sample time."""
    return Derived(
        pre_filter.prepare(of_prefilter(p), T_s),
        double_lead.prepare(of_feedback(p), T_s),
        gantry_x_filters.prepare(p.filters, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""
    x_pre, pre = linear_prefilter.step(
        x.prefilter, linear_prefilter.Input(u.x_r), of_prefilter(p), T_s, d.prefilter
    )
    x_fb, fb = double_lead.step(
        x.feedback, double_lead.Input(pre.x_f, u.x_m), of_feedback(p), T_s, d.feedback
    )
    _, force = mass_feedforward.step(
        mass_feedforward.State(),
        mass_feedforward.Input(u.a_xr),
        mass_feedforward.Parameters(p.m_x, p.feedforward.on),
        T_s,
    )
    x_fp, control = gantry_x_filters.step(
        x.filters,
        gantry_x_filters.Input(fb.v, force.u_ff + u.u_d),
        p.filters,
        T_s,
        d.filters,
    )
    return State(x_pre, x_fb, x_fp), Output(control.u, force.u_ff, pre.x_f)


model = Sampled(
    "GantryX",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
