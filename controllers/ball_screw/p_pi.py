"""P-PI cascade with feed-forward: the whole controller in one sample.

    x_r' = prefilter(x_r)                          all gains zero by default
    v    = velocity_pi(K_px (x_r' - y_2), x_r', y_1)
    u    = G_fp v + (m_1 + m_2) D²x_r' + (b_1 + b_2) D x_r' + d(v_r) + u_d

The parts are models of their own; here they run one after the other at the same
instant.  Of the command's derivatives only v_r is used, by the friction law.
Source: Gordon 2010, sec. 3.3, fig. 3.9, eq. 3.25.
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

from controllers.ball_screw import (
    filter_pack,
    friction_feedforward,
    inertia_feedforward,
    position_p,
    velocity_pi,
)
from controllers.ball_screw._command import Input, Inversion, Output
from controllers.ball_screw._drive import Rigid
from controllers.filters import prefilter as pre_filter
from controllers.filters._sections import LowPass
from fmus.model import Included, Sampled, Var


class State(NamedTuple):
    prefilter: pre_filter.State = pre_filter.State()
    velocity: velocity_pi.State = velocity_pi.State()
    inversion: inertia_feedforward.State = inertia_feedforward.State()
    filters: filter_pack.State = filter_pack.State()


class Parameters(NamedTuple):
    drive: Annotated[Rigid, Included()] = Rigid()
    K_px: Annotated[float, Var("1/s", "position gain")] = 189.0
    K_pv: Annotated[float, Var("V.s/rad", "velocity gain")] = 0.91
    K_iv: Annotated[float, Var("V/rad", "integral gain")] = 119.0
    velocity_feedforward: Annotated[bool, Var("1", "add D x_r to the command")] = True
    pre: Annotated[pre_filter.Gains, Included()] = pre_filter.Gains()
    inversion: Inversion = Inversion()
    filters: filter_pack.Parameters = filter_pack.Parameters()
    friction: friction_feedforward.Parameters = friction_feedforward.Parameters()


class Derived(NamedTuple):
    prefilter: LowPass
    filters: filter_pack.Derived


def of_prefilter(p: Parameters) -> pre_filter.Parameters:
    """Return the pre-filter's own parameters."""
    return pre_filter.Parameters(*p.pre)


def of_inversion(p: Parameters) -> inertia_feedforward.Parameters:
    """Return the inertia feed-forward's own parameters."""
    return inertia_feedforward.Parameters(p.drive, p.inversion.on)


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match the filters at the sample time."""
    return Derived(
        pre_filter.prepare(of_prefilter(p), T_s),
        filter_pack.prepare(p.filters, T_s),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Run the parts in the order of the signal."""
    x_pre, pre = pre_filter.step(
        x.prefilter, pre_filter.Input(u.x_r), of_prefilter(p), T_s, d.prefilter
    )
    _, pos = position_p.step(
        position_p.State(),
        position_p.Input(pre.x_f, u.y_2),
        position_p.Parameters(p.K_px),
        T_s,
    )
    x_vel, vel = velocity_pi.step(
        x.velocity,
        velocity_pi.Input(pos.v_c, pre.x_f, u.y_1),
        velocity_pi.Parameters(p.K_pv, p.K_iv, p.velocity_feedforward),
        T_s,
    )
    x_inv, inv = inertia_feedforward.step(
        x.inversion, inertia_feedforward.Input(pre.x_f), of_inversion(p), T_s
    )
    _, friction = friction_feedforward.step(
        friction_feedforward.State(),
        friction_feedforward.Input(u.v_r),
        p.friction,
        T_s,
    )
    x_fp, control = filter_pack.step(
        x.filters,
        filter_pack.Input(vel.v, inv.u_ff, friction.u_f + u.u_d),
        p.filters,
        T_s,
        d.filters,
    )
    x_next = State(x_pre, x_vel, x_inv, x_fp)
    return x_next, Output(control.u, inv.u_ff, pre.x_f)


model = Sampled(
    "PPI",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 20_000),
    prepare=prepare,
)
