"""The page of a fit: what was found, measured beside simulated, what is left."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orchestrator.report.facts import table
from orchestrator.report.figure import decimate
from orchestrator.report.shell import shown, written
from orchestrator.report.swept import HELD

Array = NDArray[np.float64]
MEASURED = "#888"
LEFT = "#d1495b"


class Compared(NamedTuple):
    """One signal, measured and simulated, both (rows,), and its unit."""

    name: str
    unit: str
    measured: Array
    simulated: Array


def write_fitted(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    words: Sequence[str],
    time: Array,
    until: float,
    signals: Sequence[Compared],
    path: Path,
) -> Path:
    """Write the page and return its path; rows up to ``until`` (s) were used."""
    told = [f"<p>{escape(line)}</p>" for line in words]
    listed = table(head, [[escape(cell) for cell in row] for row in rows])
    pictures = (shown(_picture(time, until, signal)) for signal in signals)
    return written(title, [listed, *told, *pictures], path)


def _picture(time: Array, until: float, signal: Compared) -> Any:
    from plotly.subplots import make_subplots

    picture = make_subplots(
        rows=2,
        cols=1,
        shared_xaxes=True,
        row_heights=[0.65, 0.35],
        vertical_spacing=0.06,
    )
    left = signal.simulated - signal.measured
    curves: Mapping[str, tuple[Array, int, Mapping[str, Any]]] = {
        "measured": (signal.measured, 1, {"color": MEASURED, "width": 3}),
        "simulated": (signal.simulated, 1, {"color": HELD, "width": 1.2}),
        "simulated - measured": (left, 2, {"color": LEFT, "width": 1}),
    }
    for name, (values, row, line) in curves.items():
        t, y = decimate(time, values)
        picture.add_scatter(x=t, y=y, name=name, line=line, row=row, col=1)
    if until < time[-1]:
        picture.add_vrect(
            x0=until,
            x1=time[-1],
            fillcolor="#f2c14e",
            opacity=0.15,
            line_width=0,
            annotation_text="not used",
            annotation_position="top right",
        )
    unit = "" if signal.unit == "1" else f" ({signal.unit})"
    picture.update_yaxes(title_text=f"{signal.name}{unit}", row=1, col=1)
    picture.update_yaxes(title_text=f"left{unit}", row=2, col=1)
    picture.update_xaxes(title_text="time from the first row (s)", row=2, col=1)
    picture.update_layout(
        height=520,
        template="plotly_white",
        margin={"l": 80, "r": 20, "t": 30, "b": 50},
        legend={"orientation": "h", "y": 1.08},
    )
    return picture
