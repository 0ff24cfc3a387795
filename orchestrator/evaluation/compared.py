"""Which rows of its signals a metric takes.

Two signals are compared where both are published and recorded: a command that
changes at 1 kHz says nothing about an error between its ticks.  What a ramp or a
stair reads beside a signal is what is held then, so that only the rows count.
With ``at`` the rows of that rate are taken, all of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import MetricSpec, OnsetMetric, SustainedMetric
from orchestrator.master.layout import Column
from orchestrator.quantities.instants import Instants
from orchestrator.quantities.quantity import rate
from orchestrator.result import Recorded, Result, Signal

Tables: TypeAlias = Mapping[Fraction, Sequence[Column]]

EXACT = 2.0**53  # up to which a number with a point holds every whole one


def loses_digits(spec: MetricSpec, signals: Mapping[str, Signal]) -> str | None:
    """Return the signal of a metric of which a figure would lose digits, if any."""
    for name in spec.signals().values():
        values = signals[name].values if name in signals else np.empty(0)
        if values.dtype.kind in "iu" and np.any(np.abs(values.astype(float)) > EXACT):
            return name
    return None


def taken(spec: MetricSpec, signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """Return a metric's signals by key, all with the same times.

    Raises:
        ScenarioError: one is not recorded, or they have no instant in common.
    """
    if spec.at is not None and isinstance(signals, Result | Recorded):
        signals = signals.at(spec.at)
    found = {key: _recorded(name, signals) for key, name in spec.signals().items()}
    found = {key: replace(s, values=s.values.astype(float)) for key, s in found.items()}
    first, *others = found.values()
    kept = np.ones(len(first), dtype=bool)
    for other in others:
        if other.time is not first.time:
            kept &= np.isin(first.time, other.time)
    for signal in found.values():
        if others and _holds_back(spec) and signal.published is not None:
            kept &= signal.published.among(first.time)
    if not kept.any():
        raise ScenarioError(f"{_names(found)} have no instant in common")
    if kept.all() and all(other.time is first.time for other in others):
        return found
    time = first.time[kept]
    return {
        key: replace(
            signal, time=time, values=signal.values[np.isin(signal.time, time)]
        )
        for key, signal in found.items()
    }


def refuse_apart(
    spec: MetricSpec, tables: Tables, stop: Fraction, begin: Fraction = Fraction(0)
) -> None:
    """Refuse a metric whose signals a run from ``begin`` (s) up to ``stop`` (s) leaves
    without rows.

    Raises:
        ScenarioError: a signal is not recorded at ``at``, two have no instant in
            common, or none lies in the window.
    """
    names = spec.signals().values()
    found = [_columns(name, tables) for name in names]
    for name, periods in zip(names, found, strict=True):
        if spec.at is not None and spec.at not in periods:
            rates = " and ".join(rate(period) for period in periods)
            raise ScenarioError(
                f"at: {name} is not recorded at {rate(spec.at)} but at {rates}; add "
                f"that rate to [record]"
            )
    rows = [spec.at or min(periods) for periods in found]
    held = [c.published for row, p in zip(rows, found, strict=True) for c in p[row]]
    grids = [Instants(row) for row in rows]
    if len(found) > 1 and _holds_back(spec):
        grids += [instants for instants in held if instants is not None]
    common: Instants | None = grids[0]
    for grid in grids[1:]:
        common = common and common.common(grid)
    if common is None or not common.within(begin, stop):
        said = ", ".join(
            f"{name} is published every {_every(columns[row])} and recorded every "
            f"{float(row):g} s"
            for name, columns, row in zip(names, found, rows, strict=True)
        )
        raise ScenarioError(
            f"there is no instant up to {float(stop):g} s at which all are published "
            f"and recorded: {said}; record them at rates that meet, or say which rows "
            f'count with at = "..."'
        )
    if spec.window is not None:
        start, end = spec.window
        if not common.within(start, min(end, stop)):
            raise ScenarioError(
                f"window: no row lies in [{float(start):g}, {float(end):g}] s; there "
                f"is one every {float(common.period):g} s from {float(common.first):g} "
                f"s to {float(stop):g} s"
            )


def _holds_back(spec: MetricSpec) -> bool:
    """Tell whether a value that is only held would falsify the figure."""
    return spec.at is None and not isinstance(spec, OnsetMetric | SustainedMetric)


def _every(columns: Sequence[Column]) -> str:
    published = columns[0].published
    if published is None:
        return "instant"
    offset = f" from {float(published.first):g} s on" if published.first else ""
    return f"{float(published.period):g} s{offset}"


def _columns(name: str, tables: Tables) -> dict[Fraction, list[Column]]:
    """Return the columns of a recorded signal by row period, the shortest first."""
    found = {
        period: [c for c in columns if c.name == name]
        for period, columns in sorted(tables.items())
    }
    return {period: columns for period, columns in found.items() if columns}


def _recorded(name: str, signals: Mapping[str, Signal]) -> Signal:
    if name not in signals:
        raise ScenarioError(f"{name} was not recorded; {did_you_mean(name, signals)}")
    return signals[name]


def _names(found: Mapping[str, Signal]) -> str:
    return " and ".join(signal.name for signal in found.values())
