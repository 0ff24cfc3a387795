"""A figure of a source as a picture: matplotlib, PNG or SVG."""

from io import StringIO
from itertools import count, cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.drawings.making import Array, Maker, Points, Shown
from orchestrator.drawings.registry import Axis, Drawn, Panel
from orchestrator.report.figure import COLOURS, REFERENCE, decimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 4.8, 3.1  # inches of a panel
PUBLISHED = "#111111"
DASHES = ("--", ":", "-.")
STYLES: dict[str, dict[str, Any]] = {
    "line": {"linestyle": "-"},
    "dashed": {"linestyle": "--"},
    "dotted": {"linestyle": ":"},
    "points": {"linestyle": "none", "marker": "o", "markersize": 4},
    "line and points": {"linestyle": "-", "marker": "o", "markersize": 3},
}
MOST = 4000  # points of a curve that are drawn, extremes among them


def picture(number: str, drawn: Drawn, maker: Maker) -> "Figure":
    """Return the picture of a figure.

    Raises:
        FeedDriveError: a curve cannot be made.
    """
    from matplotlib.figure import Figure

    columns = min(drawn.columns, len(drawn.panels))
    rows = -(-len(drawn.panels) // columns)
    tall = 1.35 if any(panel.equal for panel in drawn.panels) else 1.0
    size = (max(6.5, WIDTH * columns), HEIGHT * rows * tall + 0.5)
    figure = Figure(figsize=size, layout="constrained")
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, axes in zip(drawn.panels, places, strict=False):
        shown = [maker.shown(mark, panel) for mark in panel.marks]
        _draw(axes, panel, maker.curves(panel), shown)
    for axes in places[len(drawn.panels) :]:
        axes.set_axis_off()
    figure.suptitle(f"{caption(number)}: {drawn.title}", fontsize=10)
    return figure


def caption(number: str) -> str:
    """Return ``Fig. 3.11`` or ``Fig. 4-2`` of a figure's name."""
    return "Fig. " + number.removeprefix("fig_").replace("_", ".")


def save(figure: "Figure", file: Path) -> Path:
    """Write the picture in the form that the suffix says: .png or .svg."""
    figure.savefig(file, dpi=130)
    return file


def as_svg(figure: "Figure") -> str:
    """Return the picture as an element of a page."""
    text = StringIO()
    figure.savefig(text, format="svg")
    svg = text.getvalue()
    return svg[svg.index("<svg") :]


def _draw(axes: Any, panel: Panel, curves: list[Points], shown: list[Shown]) -> None:
    colours = count()
    for curve in curves:
        number = next(colours) if curve.colour is None and not curve.grey else None
        chosen = curve.colour if number is None else number
        colour = REFERENCE if curve.grey else COLOURS[(chosen or 0) % len(COLOURS)]
        x, y = _seen(panel.x, curve)
        label = curve.name or None
        axes.plot(x, y, color=colour, lw=1.1, label=label, **STYLES[curve.style])
    _lay_out(axes, panel)
    for mark, dash in zip(shown, cycle(DASHES), strict=False):
        _mark(axes, mark, dash)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(framealpha=0.75, edgecolor="none", fontsize=7, loc="best")


def _seen(axis: Axis, curve: Points) -> tuple[Array, Array]:
    """Return what of a curve is inside the axis, thinned where it is a long record."""
    x, y = curve.x, curve.y
    if np.any(np.diff(x) < 0):
        return x, y
    if axis.range:
        first = max(0, int(np.searchsorted(x, axis.range[0])) - 1)
        last = int(np.searchsorted(x, axis.range[1])) + 1
        x, y = x[first:last], y[first:last]
    return (x, y) if axis.log else decimate(x, y, MOST)


def _lay_out(axes: Any, panel: Panel) -> None:
    from matplotlib.ticker import NullFormatter

    for axis, name in ((panel.x, "x"), (panel.y, "y")):
        getattr(axes, f"set_{name}label")(_label(axis), fontsize=8)
        if axis.log:
            getattr(axes, f"set_{name}scale")("log")
            getattr(axes, f"{name}axis").set_minor_formatter(NullFormatter())
        if axis.range:
            getattr(axes, f"set_{name}lim")(*axis.range)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim" if not panel.x.range else "box")
    if panel.title:
        axes.set_title(panel.title, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3, which="both" if panel.x.log else "major", lw=0.5)
    axes.spines[["top", "right"]].set_visible(False)


def _label(axis: Axis) -> str:
    unit = axis.unit.replace("^0.5", "$^{1/2}$").replace("um", "µm")
    return axis.label if unit == "1" else f"{axis.label} ({unit})"


def _mark(axes: Any, mark: Shown, dash: str) -> None:
    style = {"color": PUBLISHED, "lw": 0.9, "linestyle": dash, "zorder": 1}
    said = mark.text or "published"
    if mark.x is not None and mark.y is not None:
        x, y = (np.array(ends) for ends in (mark.x, mark.y))
        half = [np.ptp(ends) / 2 or None for ends in (x, y)]
        label = f"{said} ({_said(mark.x)}, {_said(mark.y)})"
        open_ = {"fmt": "D", "color": PUBLISHED, "mfc": "none", "ms": 6}
        axes.errorbar(x.mean(), y.mean(), half[1], half[0], label=label, **open_)
        return
    ends, along = (mark.x, "v") if mark.x is not None else (mark.y, "h")
    assert ends is not None
    text = f"{said} {_said(ends)}"
    if ends[0] == ends[1]:
        getattr(axes, f"ax{along}line")(ends[0], label=text, **style)
    else:
        span = getattr(axes, f"ax{along}span")
        span(*ends, color=PUBLISHED, alpha=0.1, lw=0, label=text)


def _said(ends: tuple[float, float]) -> str:
    return " to ".join(f"{end:.4g}" for end in dict.fromkeys(ends))
