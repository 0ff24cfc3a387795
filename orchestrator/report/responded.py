"""The page of a frequency response: Bode, Nyquist, S and T with their borders."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orchestrator.report.facts import table
from orchestrator.report.shell import shown, written
from orchestrator.report.swept import FAILED, HEIGHT, HELD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
OTHER = "#888"


class Curve(NamedTuple):
    """One loop: L, S, T (lines,) at ``hz``; ``other`` ones are drawn thin and grey."""

    name: str
    hz: Real
    L: Complex
    S: Complex
    T: Complex
    other: bool = False


def write_responded(
    title: str,
    words: Sequence[str],
    tables: Sequence[tuple[Sequence[str], Sequence[Sequence[str]]]],
    curves: Sequence[Curve],
    borders: Mapping[str, float],
    path: Path,
) -> Path:
    """Write the page and return its path; ``borders`` are levels of |S| by name."""
    told = [f"<p>{escape(line)}</p>" for line in words]
    listed = [
        table(head, [[escape(cell) for cell in row] for row in rows])
        for head, rows in tables
    ]
    pictures = (bode(curves), nyquist(curves), sensitivity(curves, borders))
    return written(title, [*listed, *told, *map(shown, pictures)], path)


def _line(curve: Curve) -> dict[str, Any]:
    return {"color": OTHER, "width": 1} if curve.other else {"color": HELD, "width": 2}


def bode(curves: Sequence[Curve]) -> Any:
    """Return magnitude (dB) and phase (deg) of L over frequency."""
    from plotly.subplots import make_subplots

    picture = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for curve in curves:
        style = {"x": curve.hz, "line": _line(curve), "name": curve.name}
        picture.add_scatter(y=_db(curve.L), row=1, col=1, **style)
        phase = np.degrees(np.unwrap(np.angle(curve.L)))
        phase -= 360 * np.round(phase[0] / 360)
        picture.add_scatter(y=phase, row=2, col=1, showlegend=False, **style)
    picture.add_hline(y=0, line={"color": OTHER, "dash": "dot"}, row=1, col=1)
    picture.add_hline(y=-180, line={"color": OTHER, "dash": "dot"}, row=2, col=1)
    picture.update_xaxes(type="log")
    picture.update_xaxes(title_text="frequency (Hz)", row=2, col=1)
    picture.update_yaxes(title_text="|L| (dB)", row=1, col=1)
    picture.update_yaxes(title_text="phase of L (deg)", row=2, col=1)
    return _laid_out(picture, "Open loop", HEIGHT + 160)


def nyquist(curves: Sequence[Curve]) -> Any:
    """Return L in the complex plane around -1 with the circle it does not enter."""
    import plotly.graph_objects as go

    picture = go.Figure()
    for curve in curves:
        radius = 1 / np.max(np.abs(curve.S))
        picture.add_scatter(
            x=curve.L.real,
            y=curve.L.imag,
            line=_line(curve),
            name=curve.name,
            text=[f"{hz:.4g} Hz" for hz in curve.hz],
        )
        turn = np.linspace(0, 2 * np.pi, 121)
        picture.add_scatter(
            x=-1 + radius * np.cos(turn),
            y=radius * np.sin(turn),
            line={"color": FAILED, "dash": "dash", "width": 1},
            name=f"modulus margin {radius:.3g}",
        )
    picture.add_scatter(
        x=[-1], y=[0], mode="markers", marker={"color": FAILED}, name="-1"
    )
    picture.update_xaxes(range=[-3.5, 1.5], title_text="real part of L")
    picture.update_yaxes(range=[-2, 2], title_text="imaginary part", scaleanchor="x")
    return _laid_out(picture, "Nyquist", HEIGHT + 100)


def sensitivity(curves: Sequence[Curve], borders: Mapping[str, float]) -> Any:
    """Return |S| and |T| (dB) with the levels that are expected."""
    import plotly.graph_objects as go

    picture = go.Figure()
    for curve in curves:
        picture.add_scatter(
            x=curve.hz, y=_db(curve.S), line=_line(curve), name=f"S {curve.name}"
        )
        line = {**_line(curve), "dash": "dot"}
        picture.add_scatter(
            x=curve.hz, y=_db(curve.T), line=line, name=f"T {curve.name}"
        )
    for name, level in borders.items():
        picture.add_hline(
            y=20 * np.log10(level),
            line={"color": FAILED, "dash": "dash"},
            annotation_text=name,
        )
    picture.update_xaxes(type="log", title_text="frequency (Hz)")
    picture.update_yaxes(title_text="dB", range=[-60, 15])
    return _laid_out(picture, "Sensitivity S and its complement T", HEIGHT)


def _db(values: Complex) -> Real:
    size: Real = 20 * np.log10(np.maximum(np.abs(values), 1e-300))
    return size


def _laid_out(picture: Any, title: str, height: int) -> Any:
    picture.update_layout(title=title, height=height, template="plotly_white")
    return picture
