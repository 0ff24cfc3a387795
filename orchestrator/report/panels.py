"""What a report draws: panels over one time axis, several runs overlaid.

Every error metric gives two panels (reference and actual, error); the other
recorded signals share one panel per unit.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fmus.units import BaseUnit
from orchestrator.evaluation.compared import taken
from orchestrator.evaluation.metrics import scaled
from orchestrator.evaluation.schema import (
    ErrorMetric,
    MetricSpec,
    PlainMetric,
    StepMetric,
)
from orchestrator.quantities.quantity import converter
from orchestrator.quantities.unit import told, unit_of
from orchestrator.report.limits import Limit, limits
from orchestrator.system import split_name

if TYPE_CHECKING:
    from orchestrator.outcome import Run

Array: TypeAlias = NDArray[np.float64]
Meaning: TypeAlias = tuple[str, BaseUnit | None]

_LARGE = {"um": (1e4, "mm"), "mm": (1e4, "m"), "us": (1e4, "ms")}


@dataclass
class Curve:
    """One line: ``time`` (s) and ``values``, both (n,), of run number ``run``."""

    label: str
    time: Array
    values: Array
    run: int
    is_reference: bool = False


@dataclass
class Panel:
    """Curves of one unit over time, with limits and windows of their metrics.

    A window is [from, to] in s and the metric it belongs to.
    """

    title: str
    unit: str
    curves: list[Curve] = field(default_factory=list)
    limits: list[Limit] = field(default_factory=list)
    windows: list[tuple[float, float, str]] = field(default_factory=list)


def panels(runs: "Sequence[Run]") -> Iterable[Panel]:
    """Return the panels of a report; runs share the panels of equal meaning."""
    merged: dict[tuple[str, Meaning], Panel] = {}
    for number, (run, name) in enumerate(zip(runs, names_of(runs), strict=True)):
        label = f"{name}: " if len(runs) > 1 else ""
        own = {(p.title, _meaning(p.unit)): p for p in _tracking(run, number, label)}
        own |= {("", _meaning(p.unit)): p for p in _others(run, number, label)}
        for key, panel in own.items():
            known = merged.setdefault(key, Panel(panel.title, panel.unit))
            drawn = known.curves
            drawn.extend(c for c in panel.curves if not _already(c, drawn))
            known.limits.extend(panel.limits)
            known.windows.extend(panel.windows)
    return merged.values()


def name_of(run: "Run") -> str:
    """Return a short name of a run for legends and tables."""
    return run.scenario.spec.title or run.scenario.name.rpartition("/")[2]


def names_of(runs: "Sequence[Run]") -> list[str]:
    """Return names that tell runs apart, without the ending all have in common."""
    names = [name_of(run) for run in runs]
    words = [name.split() for name in names]
    while all(words) and len({line[-1] for line in words}) == 1:
        words = [line[:-1] for line in words]
    short = [" ".join(line).rstrip(",") for line in words]
    return short if all(short) and len(runs) > 1 else names


def _already(curve: Curve, known: Sequence[Curve]) -> bool:
    """Tell whether a reference is already drawn: equal runs follow one command."""
    return curve.is_reference and any(
        k.is_reference and np.array_equal(k.values, curve.values) for k in known
    )


def _tracking(run: "Run", number: int, label: str) -> Iterable[Panel]:
    for name, metric in run.scenario.spec.metrics.items():
        if not isinstance(metric, ErrorMetric):
            continue
        found = taken(metric, run)
        of, against = found["of"], found["against"]
        parameter = run.composition.parameter
        actual, unit = scaled(metric, of, parameter, metric.unit)
        reference, _ = scaled(metric, against, parameter, unit)
        error = reference - actual
        large, its = readable(unit, np.max(np.abs(reference)))
        first = Panel(f"{name}: reference and actual", its)
        first.curves = [
            Curve(metric.against, against.time, large(reference), number, True),
            Curve(label + metric.of, of.time, large(actual), number),
        ]
        yield first
        second = Panel(f"{name}: error", unit)
        second.curves = [Curve(f"{label}error", of.time, error, number)]
        second.limits = list(limits(run, name, unit, of_signal=False))
        second.windows = list(_windows(name, metric))
        yield second


def readable(unit: str, peak: float) -> tuple[Any, str]:
    """Return a conversion to the unit in which values up to ``peak`` read well."""
    limit, larger = _LARGE.get(unit, (np.inf, unit))
    return (converter(unit, larger), larger) if peak > limit else (lambda v: v, unit)


def _others(run: "Run", number: int, label: str) -> Iterable[Panel]:
    taken = {
        signal
        for metric in run.scenario.spec.metrics.values()
        if isinstance(metric, ErrorMetric)
        for signal in metric.signals().values()
    }
    by_unit: dict[Meaning, list[str]] = {}
    order = {name: place for place, name in enumerate(run.composition.system.record)}
    for name in sorted(run, key=lambda n: order.get(n.partition("[")[0], len(order))):
        if name not in taken:
            by_unit.setdefault(_meaning(run[name].unit), []).append(name)
    for names in by_unit.values():
        unit = run[names[0]].unit
        panel = Panel(_title(run, names, unit), unit)
        for name in names:
            signal = run[name]
            panel.curves.append(Curve(label + name, signal.time, signal.values, number))
        for metric, spec in run.scenario.spec.metrics.items():
            if spec.of in names and isinstance(spec, PlainMetric | StepMetric):
                panel.limits.extend(limits(run, metric, unit, of_signal=True))
                panel.windows.extend(_windows(metric, spec))
        yield panel


def _windows(name: str, spec: MetricSpec) -> Iterable[tuple[float, float, str]]:
    if spec.window is not None:
        yield float(spec.window[0]), float(spec.window[1]), name


def _title(run: "Run", names: Sequence[str], unit: str) -> str:
    """Return what a panel's signals are, by the FMU's own description of one."""
    if len(names) == 1:
        component, variable = split_name(names[0])
        known = run.composition.fmus[component].variables.get(variable)
        return known.description if known and known.description else names[0]
    return "other signals" if unit == "1" else f"signals in {told(unit_of(unit))}"


def _meaning(unit: str) -> Meaning:
    """Return what tells units apart that two FMUs call by one name."""
    return str(unit), unit_of(unit).base
