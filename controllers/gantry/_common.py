"""What every whole controller of the gantry's y axis reads, returns and does.

One record for all of them, so that one can take the other's place in a system;
they differ in the law between the commands of the ends and the filter pack.
"""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from controllers.filters import linear_prefilter
from controllers.filters._sections import LowPass
from controllers.gantry import averaging as gantry_averaging
from controllers.gantry import feedforward as gantry_feedforward
from controllers.gantry import filters as gantry_filters
from controllers.gantry import prefilter as gantry_prefilter
from controllers.gantry import schedule as gantry_schedule
from fmus.model import Var

Law = Callable[[gantry_averaging.Input], tuple[Any, gantry_averaging.Output]]


class Input(NamedTuple):
    y_r: Annotated[float, Var("m", "command")] = 0.0
    a_yr: Annotated[float, Var("m/s2", "commanded acceleration")] = 0.0
    y_1m: Annotated[float, Var("m", "reading of the left end")] = 0.0
    y_2m: Annotated[float, Var("m", "reading of the right end")] = 0.0
    x_s: Annotated[float, Var("m", "scheduling position, the x command")] = 0.0
    u_d1: Annotated[float, Var("V", "excitation of the left motor")] = 0.0
    u_d2: Annotated[float, Var("V", "excitation of the right motor")] = 0.0


class Output(NamedTuple):
    u_1: Annotated[float, Var("V", "control signal of the left motor")]
    u_2: Annotated[float, Var("V", "control signal of the right motor")]
    y_1f: Annotated[float, Var("m", "pre-filtered command of the left end")]
    y_2f: Annotated[float, Var("m", "pre-filtered command of the right end")]


class Common(NamedTuple):
    """Memories of the parts that all these controllers have."""

    prefilter: linear_prefilter.State
    filters: gantry_filters.State


class Coefficients(NamedTuple):
    """What those parts compute once per parameter change."""

    prefilter: LowPass
    filters: gantry_filters.Derived


class Settings(NamedTuple):
    """Parameters of those parts."""

    schedule: gantry_schedule.Parameters
    prefilter: gantry_prefilter.Parameters
    feedforward: gantry_feedforward.Parameters
    filters: gantry_filters.Parameters


def settings(p: Any) -> Settings:
    """Return the parameters of those parts from a whole controller's."""
    return Settings(schedule(p), p.prefilter, p.feedforward, p.filters)


def schedule(p: Any) -> gantry_schedule.Parameters:
    """Return the schedule's own parameters from a whole controller's."""
    return gantry_schedule.Parameters(p.m, p.m_x, p.L, p.J_0, p.d, p.alpha_0)


def prepare(p: Settings, T_s: float) -> Coefficients:
    """Match pre-filter and filter pack at the sample time."""
    return Coefficients(
        gantry_prefilter.prepare(p.prefilter, T_s),
        gantry_filters.prepare(p.filters, T_s),
    )


def around(
    law: Law, x: Common, u: Input, p: Settings, T_s: float, d: Coefficients
) -> tuple[Common, Any, Output]:
    """Run schedule, pre-filter, law, feed-forward and filters, in this order.

    Returns the memories of the common parts, those of the law, and the outputs.
    """
    _, now = gantry_schedule.step(
        gantry_schedule.State(), gantry_schedule.Input(u.x_s), p.schedule, T_s
    )
    x_pre, pre = gantry_prefilter.step(
        x.prefilter, gantry_prefilter.Input(u.y_r), p.prefilter, T_s, d.prefilter
    )
    x_law, v = law(
        gantry_averaging.Input(
            pre.y_1f, pre.y_2f, u.y_1m, u.y_2m, now.alpha_1, now.alpha_2
        )
    )
    _, force = gantry_feedforward.step(
        gantry_feedforward.State(),
        gantry_feedforward.Input(u.a_yr, now.m_11, now.m_12, now.m_22),
        p.feedforward,
        T_s,
    )
    x_fp, control = gantry_filters.step(
        x.filters,
        gantry_filters.Input(v.v_1, v.v_2, force.u_ff1 + u.u_d1, force.u_ff2 + u.u_d2),
        p.filters,
        T_s,
        d.filters,
    )
    outputs = Output(control.u_1, control.u_2, pre.y_1f, pre.y_2f)
    return Common(x_pre, x_fp), x_law, outputs
