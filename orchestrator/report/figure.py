"""The curves of a report: panels over one time axis, several runs overlaid.

Every error metric gives two panels (reference and actual, error); the other
recorded signals share one panel per unit.  A trace has at most 5,000 points:
the smallest and the largest of each stretch, so that no peak is lost.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.evaluation.compared import taken
from orchestrator.evaluation.metrics import scaled
from orchestrator.evaluation.schema import ErrorMetric
from orchestrator.quantity import converter
from orchestrator.system import split_name

if TYPE_CHECKING:
    from orchestrator.outcome import Run

Array: TypeAlias = NDArray[np.float64]

POINTS = 5000
COLOURS = ("#1f5fa8", "#d1495b", "#2e8b57", "#e09f3e", "#6c4f9c", "#3a9fb5", "#7f7f7f")
DASHES = ("solid", "dot", "dash", "dashdot")
REFERENCE = "#8a8f98"
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
    """Curves of one unit over time."""

    title: str
    unit: str
    curves: list[Curve] = field(default_factory=list)


def figure(runs: "Sequence[Run]") -> Any:
    """Return the Plotly figure of one run or of several overlaid."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    shown = list(panels(runs))
    count = max(1, len(shown))
    gap = min(0.06, 0.28 / count)
    plot = make_subplots(
        rows=count,
        cols=1,
        shared_xaxes=True,
        vertical_spacing=gap,
        subplot_titles=[panel.title for panel in shown],
    )
    for row, panel in enumerate(shown, start=1):
        styles: dict[str, int] = {}
        for curve in panel.curves:
            time, values = decimate(curve.time, curve.values)
            plot.add_trace(
                go.Scattergl(
                    x=time,
                    y=values,
                    name=curve.label,
                    mode="lines",
                    line=_line(curve, len(runs) > 1, styles),
                    legend=f"legend{row if row > 1 else ''}",
                    hovertemplate="%{y:.6g} " + panel.unit,
                ),
                row=row,
                col=1,
            )
        plot.update_yaxes(title_text=panel.unit, row=row, col=1)
        top = 1 - (row - 1) * (1 + gap) / count if count > 1 else 1.0
        key = f"legend{row if row > 1 else ''}"
        plot.update_layout({key: {"x": 1.01, "y": top, "yanchor": "top"}})
    plot.update_xaxes(title_text="time in s", row=count, col=1)
    plot.update_layout(
        template="plotly_white",
        height=120 + 240 * count,
        margin={"l": 80, "r": 20, "t": 40, "b": 50},
        hovermode="x unified",
        font={"family": "system-ui, sans-serif", "size": 13, "color": "#22262b"},
    )
    return plot


def _line(curve: Curve, compared: bool, styles: dict[str, int]) -> dict[str, Any]:
    if curve.is_reference:
        return {"color": REFERENCE, "width": 1.5, "dash": "dash"}
    number = styles.setdefault(f"{curve.run} {curve.label}", len(styles))
    if not compared:
        return {"color": COLOURS[number % len(COLOURS)], "width": 1.5}
    within = sum(key.startswith(f"{curve.run} ") for key in styles) - 1
    colour = COLOURS[curve.run % len(COLOURS)]
    return {"color": colour, "width": 1.5, "dash": DASHES[within % len(DASHES)]}


def panels(runs: "Sequence[Run]") -> Iterable[Panel]:
    """Return the panels of a report; runs share the panels of equal meaning."""
    merged: dict[tuple[str, str], Panel] = {}
    for number, (run, name) in enumerate(zip(runs, names_of(runs), strict=True)):
        label = f"{name}: " if len(runs) > 1 else ""
        own = {(p.title, p.unit): p for p in _tracking(run, number, label)}
        own |= {("", p.unit): p for p in _others(run, number, label)}
        for key, panel in own.items():
            known = merged.setdefault(key, Panel(panel.title, panel.unit)).curves
            known.extend(c for c in panel.curves if not _already(c, known))
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
    by_unit: dict[str, list[str]] = {}
    order = {name: place for place, name in enumerate(run.composition.system.record)}
    for name in sorted(run, key=lambda n: order.get(n.partition("[")[0], len(order))):
        if name not in taken:
            by_unit.setdefault(run[name].unit, []).append(name)
    for unit, names in by_unit.items():
        panel = Panel(_title(run, names, unit), unit)
        for name in names:
            signal = run[name]
            panel.curves.append(Curve(label + name, signal.time, signal.values, number))
        yield panel


def _title(run: "Run", names: Sequence[str], unit: str) -> str:
    """Return what a panel's signals are, by the FMU's own description of one."""
    if len(names) == 1:
        component, variable = split_name(names[0])
        known = run.composition.fmus[component].variables.get(variable)
        return known.description if known and known.description else names[0]
    return "other signals" if unit == "1" else f"signals in {unit}"


def decimate(time: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Thin a curve to at most ``points``, keeping the extremes of each stretch.

    ``time`` and ``values`` (n,); the first and the last point stay.
    """
    n = len(values)
    if n <= points:
        return time, values
    stretches = np.array_split(np.arange(n), points // 2 - 1)
    kept = {0, n - 1}
    for stretch in stretches:
        part = values[stretch]
        kept.add(int(stretch[np.argmin(part)]))
        kept.add(int(stretch[np.argmax(part)]))
    index = np.array(sorted(kept))
    return time[index], values[index]
