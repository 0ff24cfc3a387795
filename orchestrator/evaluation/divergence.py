"""Whether a run diverged.

A recorded signal has diverged once it passes a million times what it is to
follow: the largest reference of an error metric, height of a step or size of a
contour in the same unit.  Any other has once it passes 1e12 in SI units, which
no quantity of a machine does.  A constant passes nothing.  A scenario that
looks for its limit of stability (``onset``, ``sustained``) is meant to go
beyond it and is not judged.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from fmus.units import UnitError
from orchestrator.evaluation.metrics import Array, Parameters, factor, in_unit, scaled
from orchestrator.evaluation.schema import (
    ContourMetric,
    ErrorMetric,
    MetricSpec,
    OnsetMetric,
    StepMetric,
    SustainedMetric,
)
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import unit_of
from orchestrator.result import Signal

TIMES_FOLLOWED = 1e6
LIMIT_SI = 1e12


class _Limited(NamedTuple):
    """A signal with the size (in ``unit``) that it does not pass in a sound run."""

    name: str
    time: Array
    values: Array
    limit: float
    unit: str


def divergence(
    specs: Mapping[str, MetricSpec],
    signals: Mapping[str, Signal],
    parameter: Parameters,
) -> str | None:
    """Return which signal diverges first and when, in words; None if none does.

    ``parameter`` as for ``evaluate``; the metrics are ones that it takes.  The rows
    may be those of a run that failed.
    """
    if any(isinstance(s, OnsetMetric | SustainedMetric) for s in specs.values()):
        return None
    if not all(len(signals[name]) for name in signals):
        return None
    with np.errstate(all="ignore"):
        limited = [*_followers(specs, signals, parameter), *_others(signals)]
        passed = [(t, one) for one in limited if (t := _passing(one)) is not None]
    if not passed:
        return None
    at, first = min(passed, key=lambda found: found[0])
    size = Quantity(first.limit, first.unit)
    return f"diverged: {first.name} passes {size} at t = {at:.6g} s"


def _passing(one: _Limited) -> float | None:
    """Return when a signal that begins within its limit passes it."""
    y = one.values.astype(float)  # of whole numbers without a sign -y is none
    if max(-np.min(y), np.max(y)) <= one.limit or abs(y[0]) > one.limit:
        return None
    return float(one.time[np.argmax(np.abs(y) > one.limit)])


def _followers(
    specs: Mapping[str, MetricSpec],
    signals: Mapping[str, Signal],
    parameter: Parameters,
) -> Iterable[_Limited]:
    followers = []
    commands: dict[str, float] = {}
    for spec in specs.values():
        if not isinstance(spec, ErrorMetric | StepMetric | ContourMetric):
            continue
        values, unit = scaled(spec, signals[spec.of], parameter, spec.unit)
        followers.append((spec.of, values, unit))
        if isinstance(spec, ErrorMetric):
            reference, _ = scaled(spec, signals[spec.against], parameter, unit)
            size = float(np.max(np.abs(reference)))
        elif isinstance(spec, StepMetric):
            size = abs(in_unit(factor(spec.height, parameter), unit))
        else:
            size = in_unit(factor(spec.size, parameter), unit)
            across, _ = scaled(spec, signals[spec.across], parameter, unit)
            followers.append((spec.across, across, unit))
        commands[unit] = max(size, commands.get(unit, 0.0))
    for name, values, unit in followers:
        if command := commands[unit]:  # what is to stay at zero has no size
            limit = TIMES_FOLLOWED * command
            yield _Limited(name, signals[name].time, values, limit, unit)


def _others(signals: Mapping[str, Signal]) -> Iterable[_Limited]:
    for name in signals:
        signal = signals[name]
        try:
            base = unit_of(signal.unit).base
            limit = LIMIT_SI / abs(base.factor if base else 1.0)
        except UnitError:  # a foreign FMU may write units of its own
            limit = LIMIT_SI
        yield _Limited(name, signal.time, signal.values, limit, signal.unit)
