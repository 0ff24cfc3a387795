"""What errors and control signals are made of, a folded plot for each.

Of an error: its amplitude spectrum, its density (how often it has which value), its
course over position and over velocity of the reference (lost motion shows as two
branches, one per direction), and the stretch around its largest value, enlarged.  Of
a control signal, which a sampled component hands to a continuous one: spectrum and
density.  All of it within the window of the metric, if that has one.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from orchestrator.evaluation.compared import taken
from orchestrator.evaluation.metrics import scaled
from orchestrator.evaluation.schema import ErrorMetric
from orchestrator.evaluation.spectrum import amplitudes
from orchestrator.report.figure import COLOURS, decimate
from orchestrator.report.panels import Array, names_of, readable
from orchestrator.report.shell import folded
from orchestrator.system import split_name

if TYPE_CHECKING:
    from orchestrator.outcome import Run

BINS = 120
FINE = 400  # lines of a spectrum from the lowest on that are all drawn
WORST = 0.02  # of the rows that the enlarged stretch has, at least
FEWEST = 60
DECADES = 8.0  # of a spectrum in view; more are there
HEIGHT = 300.0  # pixels of a row of panels
GAP = 0.12  # between two rows, of the plot's height


class Series(NamedTuple):
    """Values (n,) of a run in ``unit``; of an error also where and how fast.

    ``position`` and ``velocity`` (n,) are those of the reference, in ``along`` and
    ``along``/s.
    """

    label: str
    run: int
    time: Array
    values: Array
    unit: str
    position: Array | None = None
    velocity: Array | None = None
    along: str = ""


def analysed(runs: "Sequence[Run]") -> list[str]:
    """Return a folded plot per error and per control signal of the runs."""
    found: dict[str, list[Series]] = {}
    for number, (run, label) in enumerate(zip(runs, names_of(runs), strict=True)):
        for name, series in (*_errors(run, number), *_controls(run, number)):
            found.setdefault(name, []).append(series._replace(label=label))
    return [folded(name, _plot(series)) for name, series in found.items()]


def _errors(run: "Run", number: int) -> Iterator[tuple[str, Series]]:
    parameter = run.composition.parameter
    for name, metric in run.scenario.spec.metrics.items():
        if not isinstance(metric, ErrorMetric):
            continue
        found = taken(metric, run)
        of, against = found["of"], found["against"]
        actual, unit = scaled(metric, of, parameter, metric.unit)
        reference, _ = scaled(metric, against, parameter, unit)
        start, end = metric.window or (of.time[0], of.time[-1])
        rows = (of.time >= float(start)) & (of.time <= float(end))
        time, error = of.time[rows], (reference - actual)[rows]
        if len(time) < FEWEST or not np.all(np.isfinite(error)):
            continue
        large, along = readable(unit, float(np.max(np.abs(reference))))
        position = large(reference[rows])
        velocity = np.gradient(position, time)
        series = Series("", number, time, error, unit, position, velocity, along)
        yield f"{name}: what the error is made of", series


def _controls(run: "Run", number: int) -> Iterator[tuple[str, Series]]:
    system, fmus = run.composition.system, run.composition.fmus
    kinds = {n: c.kind or fmus[n].kind for n, c in system.components.items()}
    ends = [
        (s, split_name(s)[0], split_name(k)[0]) for k, s in system.connections.items()
    ]
    handed = [s for s, a, b in ends if kinds[a] == "sampled" and kinds[b] != "sampled"]
    for name in dict.fromkeys(handed):
        if name in run:
            signal = run[name]
            values = signal.values.astype(float)
            if len(values) >= FEWEST and np.all(np.isfinite(values)):
                series = Series("", number, signal.time, values, signal.unit)
                yield f"{name}: what the control signal is made of", series


def _plot(series: Sequence[Series]) -> dict[str, Any]:
    """Return what Plotly draws, as data: its Python objects take ten times as long."""
    first = series[0]
    unit = "" if first.unit == "1" else f" ({first.unit})"
    top = max(float(np.max(next(_curves(one))[1])) for one in series)
    high = np.log10(top) + 0.3 if top > 0 else 0.0
    powers = {"type": "log", "exponentformat": "power", "range": [high - DECADES, high]}
    panels: list[tuple[str, str, dict[str, Any], dict[str, Any]]] = [
        (
            "spectrum",
            "frequency (Hz)",
            {"type": "log"},
            {**powers, "title": {"text": f"amplitude{unit}"}},
        ),
        ("density (% of rows)", f"value{unit}", {}, {}),
    ]
    if first.position is not None:
        error = {"title": {"text": f"error{unit}"}}
        panels += [
            ("over position", f"position ({first.along})", {}, error),
            ("over velocity", f"velocity ({first.along}/s)", {}, {}),
            (_worst_title(series), "time (s)", {}, error),
        ]
    rows = (len(panels) + 1) // 2
    layout: dict[str, Any] = {
        "height": 80 + HEIGHT * rows,
        "margin": {"l": 80, "r": 20, "t": 50, "b": 50},
        "legend": {"orientation": "h", "y": 1.08},
        "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#22262b"},
        "annotations": [],
    }
    for i, (title, below, x, y) in enumerate(panels):
        number = str(i + 1) if i else ""
        place = _place(i, len(panels))
        ends = {"x": place[0], "y": place[1]}
        grid = {"gridcolor": "#e8ecf1", "zerolinecolor": "#d3d9e0"}
        x = {**x, **grid, "title": {"text": below}, "anchor": f"y{number}"}
        y = {**y, **grid, "anchor": f"x{number}", "automargin": True}
        layout[f"xaxis{number}"] = {**x, "domain": ends["x"]}
        layout[f"yaxis{number}"] = {**y, "domain": ends["y"]}
        layout["annotations"].append(
            {
                "text": title,
                "x": sum(ends["x"]) / 2,
                "y": ends["y"][1],
                "xref": "paper",
                "yref": "paper",
                "xanchor": "center",
                "yanchor": "bottom",
                "showarrow": False,
                "font": {"size": 15},
            }
        )
    traces = [
        {
            "type": "scatter",
            "x": x.tolist(),
            "y": y.tolist(),
            "name": one.label,
            "legendgroup": one.label,
            "showlegend": len(series) > 1 and i == 0,
            "mode": "lines+markers" if i == 4 else "lines",
            "marker": {"size": 3},
            "line": {
                "color": COLOURS[one.run % len(COLOURS)],
                "width": 1.2,
                "shape": "hvh" if i == 1 else "linear",
            },
            "xaxis": f"x{i + 1 if i else ''}",
            "yaxis": f"y{i + 1 if i else ''}",
        }
        for one in series
        for i, (x, y) in enumerate(_curves(one))
    ]
    return {"data": traces, "layout": layout}


def _place(i: int, count: int) -> tuple[list[float], list[float]]:
    """Return from where to where panel i of some reaches, of the plot's size."""
    rows, row = (count + 1) // 2, i // 2
    alone = i == count - 1 and count % 2 == 1
    x = [0.0, 1.0] if alone else [0.0, 0.44] if i % 2 == 0 else [0.56, 1.0]
    share = (1 + GAP) / rows
    top = 1 - row * share
    return x, [max(0.0, top - share + GAP), top]


def _curves(one: Series) -> Iterator[tuple[Array, Array]]:
    """Yield what is drawn of a series, panel by panel."""
    hertz, amplitude = amplitudes(one.time, one.values)
    hertz, amplitude = hertz[1:], amplitude[1:]
    x, y = decimate(hertz[FINE:], amplitude[FINE:]) if len(hertz) > FINE else ((), ())
    yield np.concatenate([hertz[:FINE], x]), np.concatenate([amplitude[:FINE], y])
    counts, edges = np.histogram(one.values, BINS)
    yield 0.5 * (edges[1:] + edges[:-1]), 100 * counts / len(one.values)
    if one.position is None or one.velocity is None:
        return
    kept = np.searchsorted(one.time, decimate(one.time, one.values)[0])
    yield one.position[kept], one.values[kept]
    yield one.velocity[kept], one.values[kept]
    rows = _worst(one)
    yield one.time[rows], one.values[rows]


def _worst(one: Series) -> slice:
    """Return the rows around the largest value."""
    wide = max(FEWEST, int(WORST * len(one.values))) // 2
    at = int(np.argmax(np.abs(one.values)))
    return slice(max(0, at - wide), at + wide + 1)


def _worst_title(series: Sequence[Series]) -> str:
    told = []
    for one in series:
        at = int(np.argmax(np.abs(one.values)))
        unit = "" if one.unit == "1" else f" {one.unit}"
        told.append(f"{one.values[at]:.4g}{unit} at {one.time[at]:.6g} s")
    return f"worst stretch: {'; '.join(told)}"
