"""Mode-compensating pole placement (MC-PPC): the whole controller in one sample.

    x_r' = prefilter(x_r)
    v    = K (G_r x_r' - y_1, x_r' - y_2)         state feedback with integrator
    u    = G_fp v + G_ff x_r' + d(v_r) + u_d

The parts are models of their own; here they run one after the other at the same
instant, and the drive's parameters, shared by G_r and G_ff, are given once.
Source: Gordon 2010, sec. 3.2, fig. 3.1, eq. 3.5 to 3.20.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.ball_screw import (
    filter_pack,
    friction_feedforward,
    model_inversion,
    rotary_command,
    state_feedback,
)
from controllers.ball_screw._command import Input, Inversion, Output, Rotary
from controllers.ball_screw._drive import TwoMass
from controllers.filters import prefilter as pre_filter
from controllers.filters._sections import LowPass
from fmus.model import Included, Sampled, Var


class State(NamedTuple):
    prefilter: pre_filter.State = pre_filter.State()
    rotary: rotary_command.State = rotary_command.State()
    inversion: model_inversion.State = model_inversion.State()
    feedback: state_feedback.State = state_feedback.State()
    filters: filter_pack.State = filter_pack.State()


class Parameters(NamedTuple):
    drive: Annotated[TwoMass, Included()] = TwoMass()
    gains: Annotated[state_feedback.Parameters, Included()] = (
        state_feedback.Parameters()
    )
    pre: Annotated[pre_filter.Gains, Included()] = pre_filter.Gains()
    analytic: Annotated[bool, Var("1", "use the trajectory's derivatives")] = False
    rotary: Rotary = Rotary()
    inversion: Inversion = Inversion()
    filters: filter_pack.Parameters = filter_pack.Parameters()
    friction: friction_feedforward.Parameters = friction_feedforward.Parameters()


class Derived(NamedTuple):
    prefilter: LowPass
    rotary: rotary_command.Derived
    inversion: model_inversion.Derived
    filters: filter_pack.Derived


def of_prefilter(p: Parameters) -> pre_filter.Parameters:
    """Return the pre-filter's own parameters."""
    return pre_filter.Parameters(*p.pre)


def of_rotary(p: Parameters) -> rotary_command.Parameters:
    """Return the rotary command generator's own parameters."""
    _, m_2, _, b_2, k, c = p.drive
    return rotary_command.Parameters(m_2, b_2, k, c, p.rotary.on, p.analytic)


def of_inversion(p: Parameters) -> model_inversion.Parameters:
    """Return the model inversion's own parameters."""
    return model_inversion.Parameters(p.drive, p.inversion.on, p.analytic)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match every part at the sample time."""
    return Derived(
        pre_filter.prepare(of_prefilter(p), T_s),
        rotary_command.prepare(of_rotary(p), T_s),
        model_inversion.prepare(of_inversion(p), T_s),
        filter_pack.prepare(p.filters, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""
    x_pre, pre = pre_filter.step(
        x.prefilter, pre_filter.Input(u.x_r), of_prefilter(p), T_s, d.prefilter
    )
    x_rot, rot = rotary_command.step(
        x.rotary,
        rotary_command.Input(pre.x_f, u.v_r, u.a_r),
        of_rotary(p),
        T_s,
        d.rotary,
    )
    x_inv, inv = model_inversion.step(
        x.inversion,
        model_inversion.Input(pre.x_f, u.v_r, u.a_r, u.j_r, u.s_r),
        of_inversion(p),
        T_s,
        d.inversion,
    )
    x_fb, fb = state_feedback.step(
        x.feedback,
        state_feedback.Input(rot.x_1r, pre.x_f, u.y_1, u.y_2),
        p.gains,
        T_s,
    )
    _, friction = friction_feedforward.step(
        friction_feedforward.State(),
        friction_feedforward.Input(u.v_r),
        p.friction,
        T_s,
    )
    x_fp, control = filter_pack.step(
        x.filters,
        filter_pack.Input(fb.v, inv.u_ff, friction.u_f + u.u_d),
        p.filters,
        T_s,
        d.filters,
    )
    x_next = State(x_pre, x_rot, x_inv, x_fb, x_fp)
    return x_next, Output(control.u, inv.u_ff, pre.x_f)


model = Sampled(
    "MCPPC",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
