"""Contours of a report: the path in the plane, its error magnified.

A plot per contour metric, runs overlaid: the contour itself, and each run's
points moved away from the nearest point of the contour by their distance times
one round number for all, so that the largest error spans up to a fifth of it.
"""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.evaluation.compared import taken
from orchestrator.evaluation.metrics import scaled
from orchestrator.evaluation.motion import contour_error, nearest_on_contour
from orchestrator.evaluation.schema import ContourMetric
from orchestrator.report.figure import COLOURS, REFERENCE, decimate
from orchestrator.report.panels import names_of, readable

if TYPE_CHECKING:
    from orchestrator.outcome import Run

Array: TypeAlias = NDArray[np.float64]

SHARE = 0.2  # of the contour's size that the largest error spans


class Traced(NamedTuple):
    """A run's path about a contour, all (n,), in ``unit``.

    ``foot`` is the nearest point of the contour, ``away`` the vector from it to
    the path, ``error`` the signed distance; ``of`` counts the points recorded.
    """

    label: str
    metric: str
    axes: tuple[str, str]
    shape: str
    size: float
    unit: str
    foot: tuple[Array, Array]
    away: tuple[Array, Array]
    error: Array
    of: int


def contours(runs: "Sequence[Run]") -> list[Any]:
    """Return a Plotly figure for each contour metric of the runs."""
    found: dict[str, list[Traced]] = {}
    for run, label in zip(runs, names_of(runs), strict=True):
        for path in traced(run, label):
            found.setdefault(path.metric, []).append(path)
    return [_figure(name, paths) for name, paths in found.items()]


def traced(run: "Run", label: str) -> Iterable[Traced]:
    """Return the paths of a run about its contours, thinned for drawing."""
    parameter = run.composition.parameter
    for name, metric in run.scenario.spec.metrics.items():
        if not isinstance(metric, ContourMetric):
            continue
        found = taken(metric, run)
        of = found["of"]
        x, unit = scaled(metric, of, parameter, metric.unit)
        y, _ = scaled(metric, found["across"], parameter, unit)
        size = metric.size
        if isinstance(size, str):
            size = parameter(size).to(unit).value
        start, end = metric.window or (of.time[0], of.time[-1])
        inside = (of.time >= float(start)) & (of.time <= float(end))
        time, x, y = of.time[inside], x[inside], y[inside]
        error = contour_error(x, y, metric.shape, size)
        kept = np.searchsorted(time, decimate(time, error)[0])
        points = len(error)
        x, y, error = x[kept], y[kept], error[kept]
        foot = nearest_on_contour(x, y, metric.shape, size)
        away = x - foot[0], y - foot[1]
        axes = metric.of, metric.across
        where = size, unit, foot, away, error, points
        yield Traced(label, name, axes, metric.shape, *where)


def magnification(paths: Sequence[Traced]) -> float:
    """Return 1, 2 or 5 times a power of ten that makes the largest error visible."""
    largest = max(float(np.max(np.abs(path.error))) for path in paths)
    if largest == 0:
        return 1.0
    wanted = SHARE * max(path.size for path in paths) / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(1.0, power * max(n for n in (1, 2, 5) if n * power <= wanted)))


def _figure(name: str, paths: Sequence[Traced]) -> Any:
    import plotly.graph_objects as go

    M = magnification(paths)
    plot = go.Figure()
    large, unit = readable(paths[0].unit, paths[0].size)
    x, y = outline(paths[0])
    plot.add_trace(
        go.Scatter(
            x=large(x),
            y=large(y),
            name="contour",
            mode="lines",
            hoverinfo="skip",
            line={"color": REFERENCE, "width": 1.5, "dash": "dash"},
        )
    )
    for number, path in enumerate(paths):
        plot.add_trace(
            go.Scatter(
                x=large(path.foot[0] + M * path.away[0]),
                y=large(path.foot[1] + M * path.away[1]),
                customdata=path.error,
                name=path.label,
                mode="lines",
                line={"color": COLOURS[number % len(COLOURS)], "width": 1.5},
                hovertemplate="error %{customdata:.4g} " + path.unit,
            )
        )
    plot.update_xaxes(title_text=f"{paths[0].axes[0]} in {unit}")
    plot.update_yaxes(title_text=f"{paths[0].axes[1]} in {unit}", scaleanchor="x")
    plot.update_layout(
        title={
            "text": f"{name}: error magnified {M:,.0f} times",
            "subtitle": {"text": _honest(paths)},
        },
        template="plotly_white",
        height=640,
        margin={"l": 80, "r": 20, "t": 60, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 13, "color": "#22262b"},
    )
    return plot


def _honest(paths: Sequence[Traced]) -> str:
    """Say how much of the paths is drawn, where it is not all."""
    path = max(paths, key=lambda p: p.of)
    if path.of == len(path.error):
        return ""
    return (
        f"through {len(path.error):,} of {path.of:,} recorded points, the largest "
        f"errors among them; between two that are drawn it is not what was recorded"
    )


def outline(path: Traced) -> tuple[Array, Array]:
    """Return the points of a contour itself, each (n,)."""
    round_ = path.shape in ("circle", "rose")
    angle = np.linspace(0, 2 * np.pi, 1441 if round_ else 5)
    if path.shape == "rose":
        r = path.size * np.cos(2 * angle)
        return r * np.cos(angle), r * np.sin(angle)
    corner = path.size * (np.sqrt(0.5) if path.shape == "square" else 1.0)
    return corner * np.cos(angle), corner * np.sin(angle)
