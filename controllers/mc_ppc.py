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

from controllers import (
    filter_pack,
    friction_feedforward,
    model_inversion,
    rotary_command,
    state_feedback,
)
from controllers import prefilter as pre_filter
from controllers._command import Input, Inversion, Output, Rotary
from controllers._sections import LowPass
from fmus.model import Sampled, Var


class State(NamedTuple):
    prefilter: pre_filter.State = pre_filter.State()
    rotary: rotary_command.State = rotary_command.State()
    inversion: model_inversion.State = model_inversion.State()
    feedback: state_feedback.State = state_feedback.State()
    filters: filter_pack.State = filter_pack.State()


class Parameters(NamedTuple):
    m_1: Annotated[float, Var("V.s2/rad", "rotating inertia", min=1e-9)] = 1.858e-3
    m_2: Annotated[float, Var("V.s2/rad", "translating inertia", min=1e-9)] = 0.379e-3
    b_1: Annotated[float, Var("V.s/rad", "damping of motor and bearings", min=0)] = (
        1.020e-3
    )
    b_2: Annotated[float, Var("V.s/rad", "damping of the guideways", min=0)] = 0.0
    k: Annotated[float, Var("V/rad", "axial stiffness", min=1e-9)] = 210.02
    c: Annotated[float, Var("V.s/rad", "damping of the nut", min=0)] = 0.014
    K_x1: Annotated[float, Var("V/rad", "gain on the screw error")] = 632.965300
    K_x2: Annotated[float, Var("V/rad", "gain on the table error")] = -83.312458
    K_v1: Annotated[float, Var("V.s/rad", "gain on the screw error rate")] = 1.648469979
    K_v2: Annotated[float, Var("V.s/rad", "gain on the table error rate")] = 0.264903101
    K_i2: Annotated[float, Var("V/(rad.s)", "gain on the integral")] = 70135.3877
    K_vel: Annotated[float, Var("s", "pre-filter gain on the velocity")] = 0.0
    K_acc: Annotated[float, Var("s2", "pre-filter gain on the acceleration")] = 0.0
    K_jerk: Annotated[float, Var("s3", "pre-filter gain on the jerk")] = 0.0
    K_snap: Annotated[float, Var("s4", "pre-filter gain on the snap")] = 0.0
    omega_c_hz: Annotated[float, Var("Hz", "low-pass of the pre-filter", min=0)] = 80.0
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
    return pre_filter.Parameters(p.K_vel, p.K_acc, p.K_jerk, p.K_snap, p.omega_c_hz)


def of_rotary(p: Parameters) -> rotary_command.Parameters:
    """Return the rotary command generator's own parameters."""
    return rotary_command.Parameters(p.m_2, p.b_2, p.k, p.c, p.rotary.on, p.analytic)


def of_inversion(p: Parameters) -> model_inversion.Parameters:
    """Return the model inversion's own parameters."""
    return model_inversion.Parameters(
        p.m_1, p.m_2, p.b_1, p.b_2, p.k, p.c, p.inversion.on, p.analytic
    )


def of_feedback(p: Parameters) -> state_feedback.Parameters:
    """Return the state feedback's own parameters."""
    return state_feedback.Parameters(p.K_x1, p.K_x2, p.K_v1, p.K_v2, p.K_i2)


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
        of_feedback(p),
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
