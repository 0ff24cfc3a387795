"""The picture of a report's panels, drawn by Plotly.

A trace begins with at most 3,000 points, the smallest and the largest of each
stretch, so that no peak is lost; the page draws it anew from all points when it
is zoomed (``zoom.js``).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.report.panels import Array, Curve, Panel, panels

if TYPE_CHECKING:
    from orchestrator.outcome import Run

TINY = 1e-300  # Plotly fails at axes that would span denormal numbers
MARKED = 250  # points up to which each has its mark
POINTS = 3000  # two of each stretch that zoom.js draws
# each has a contrast above 3 to white and to the dark page
COLOURS = ("#2f78c4", "#d1495b", "#2e9360", "#bf7b1a", "#8a6cc4", "#2588a0", "#7f7f7f")
DASHES = ("solid", "dot", "dash", "dashdot")
REFERENCE = "#8a8f98"
LIMIT = "#c8475a"
FAR = 5.0  # times the largest value of a panel: a limit beyond is only named


@dataclass
class Drawing:
    """A Plotly figure, and its curves by the number of their trace."""

    plot: Any
    curves: dict[int, Curve] = field(default_factory=dict)


def figure(runs: "Sequence[Run]") -> Drawing:
    """Return the Plotly figure of one run or of several overlaid."""
    return drawn(list(panels(runs)), overlaid=len(runs) > 1)


def drawn(shown: Sequence[Panel], *, overlaid: bool) -> Drawing:
    """Return panels below each other; ``overlaid``: a colour per run, not per curve."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    count = max(1, len(shown))
    gap = min(0.06, 0.28 / count)
    plot = make_subplots(
        rows=count,
        cols=1,
        shared_xaxes=True,
        vertical_spacing=gap,
        subplot_titles=[panel.title for panel in shown],
    )
    drawing = Drawing(plot)
    for row, panel in enumerate(shown, start=1):
        styles: dict[str, int] = {}
        for curve in panel.curves:
            drawing.curves[len(plot.data)] = curve
            time, values = decimate(curve.time, curve.values)
            plot.add_trace(
                go.Scatter(
                    x=time,
                    y=np.where(np.abs(values) < TINY, 0.0, values),
                    name=curve.label,
                    mode="lines+markers" if len(time) <= MARKED else "lines",
                    line=_line(curve, overlaid, styles),
                    legend=f"legend{row if row > 1 else ''}",
                    hovertemplate="%{y:.6g} " + panel.unit,
                ),
                row=row,
                col=1,
            )
        _draw_limits(plot, panel, row)
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
    return drawing


def _draw_limits(plot: Any, panel: Panel, row: int) -> None:
    """Draw windows as shades, limits as lines; a far limit does not flatten curves."""
    for start, end, name in dict.fromkeys(panel.windows):
        shade = {"fillcolor": REFERENCE, "opacity": 0.12, "line_width": 0}
        plot.add_vrect(
            x0=start,
            x1=end,
            layer="below",
            row=row,
            col=1,
            annotation={"text": f"window of {name}", "font": {"size": 10}},
            annotation_position="top left",
            **shade,
        )
    peak = max((float(np.max(np.abs(c.values))) for c in panel.curves), default=0.0)
    begin = min((float(c.time[0]) for c in panel.curves), default=0.0)
    end = max((float(c.time[-1]) for c in panel.curves), default=0.0)
    named: set[str] = set()
    for value, label in dict.fromkeys(panel.limits):
        if abs(value) > FAR * peak:
            said = f"{label}: beyond the picture"
        else:
            said = label
            plot.add_scatter(
                x=[begin, end],
                y=[value, value],
                mode="lines",
                showlegend=False,
                hoverinfo="skip",
                line={"color": LIMIT, "width": 1, "dash": "dot"},
                row=row,
                col=1,
            )
        if label in named:
            continue
        named.add(label)
        plot.add_annotation(
            x=1,
            y=min(max(value, -peak), peak),
            xref="x domain",
            text=said,
            showarrow=False,
            xanchor="right",
            yanchor="bottom",
            font={"size": 10, "color": LIMIT},
            row=row,
            col=1,
        )


def _line(curve: Curve, compared: bool, styles: dict[str, int]) -> dict[str, Any]:
    if curve.is_reference:
        return {"color": REFERENCE, "width": 1.5, "dash": "dash"}
    number = styles.setdefault(f"{curve.run} {curve.label}", len(styles))
    if not compared:
        return {"color": COLOURS[number % len(COLOURS)], "width": 1.5}
    within = sum(key.startswith(f"{curve.run} ") for key in styles) - 1
    colour = COLOURS[curve.run % len(COLOURS)]
    return {"color": colour, "width": 1.5, "dash": DASHES[within % len(DASHES)]}


def decimate(time: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Thin a curve to at most ``points``, keeping the extremes of each stretch.

    ``time`` and ``values`` (n,); the first and the last point stay.
    """
    n = len(values)
    if n <= points:
        return time, values
    width = -(-n // (points // 2 - 1))
    rows = -(-n // width)
    stretches = np.pad(values, (0, rows * width - n), mode="edge").reshape(rows, width)
    begins = width * np.arange(rows)
    extremes = (begins + find(stretches, axis=1) for find in (np.argmin, np.argmax))
    kept = np.unique(np.concatenate([[0, n - 1], *extremes]).clip(max=n - 1))
    return time[kept], values[kept]
