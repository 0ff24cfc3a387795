"""The page of a frequency response: Bode, Nyquist, S and T with their borders, or G."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.report.facts import table
from orchestrator.report.shell import shown, written
from orchestrator.report.swept import FAILED, HEIGHT, HELD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
OWN = (HELD, "#2a9d8f", "#7b4bb7", "#a0522d")  # of several loops
OTHER, TRACED = "#888", "#c26a00"


Style: TypeAlias = Literal["own", "other", "traced"]


class Trace(NamedTuple):
    """Complex values (lines,) at ``hz``; ``other`` ones are drawn thin and grey, what
    equations give ``traced``, dashed."""

    name: str
    hz: Real
    values: Complex
    style: Style = "own"


class Curve(NamedTuple):
    """One loop: L, S, T (lines,) at ``hz``, drawn as a ``Trace``."""

    name: str
    hz: Real
    L: Complex
    S: Complex
    T: Complex
    style: Style = "own"

    @classmethod
    def of(cls, name: str, hz: Real, L: Complex, style: Style = "own") -> "Curve":
        """Return the loop with this L."""
        return cls(name, hz, L, 1 / (1 + L), L / (1 + L), style)

    @property
    def open(self) -> Trace:
        return Trace(self.name, self.hz, self.L, self.style)


def write_responded(
    title: str,
    words: Sequence[str],
    tables: Sequence[tuple[Sequence[str], Sequence[Sequence[str]]]],
    curves: Sequence[Curve],
    borders: Mapping[str, float],
    path: Path,
    loci: Sequence[Trace] = (),
) -> Path:
    """Write the page and return its path; ``borders`` are levels of |S| by name.

    ``loci`` are the eigenvalues of an L of several breaks.
    """
    pictures = [bode([curve.open for curve in curves], "L"), nyquist(curves)]
    if loci:
        pictures.append(generalised_nyquist(loci))
    pictures.append(sensitivity(curves, borders))
    return _page(title, words, tables, pictures, path)


def write_transfers(
    title: str,
    words: Sequence[str],
    tables: Sequence[tuple[Sequence[str], Sequence[Sequence[str]]]],
    traces: Sequence[Trace],
    path: Path,
) -> Path:
    """Write the page of what is between inputs and outputs and return its path."""
    return _page(title, words, tables, [bode(traces, "G")], path)


def _page(
    title: str,
    words: Sequence[str],
    tables: Sequence[tuple[Sequence[str], Sequence[Sequence[str]]]],
    pictures: Sequence[Any],
    path: Path,
) -> Path:
    told = [f"<p>{escape(line)}</p>" for line in words]
    listed = [
        table(head, [[escape(cell) for cell in row] for row in rows])
        for head, rows in tables
    ]
    return written(title, [*listed, *told, *map(shown, pictures)], path)


def _line(style: Style, dash: str = "solid", number: int = 0) -> dict[str, Any]:
    if style == "other":
        return {"color": OTHER, "width": 1, "dash": dash}
    if style == "traced":
        return {"color": TRACED, "width": 1, "dash": "dash"}
    return {"color": OWN[number % len(OWN)], "width": 2, "dash": dash}


def bode(traces: Sequence[Trace], what: str) -> Any:
    """Return magnitude (dB) and phase (deg) over frequency."""
    from plotly.subplots import make_subplots

    picture = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for i, trace in enumerate(traces):
        line = _line(trace.style, number=i)
        style = {"x": trace.hz, "line": line, "name": trace.name}
        picture.add_scatter(y=_db(trace.values), row=1, col=1, **style)
        phase = np.degrees(np.unwrap(np.angle(trace.values)))
        phase -= 360 * np.round(phase[0] / 360)
        picture.add_scatter(y=phase, row=2, col=1, showlegend=False, **style)
    dotted = {"color": OTHER, "dash": "dot"}
    if what == "L":
        picture.add_hline(y=0, line=dotted, row=1, col=1)
    picture.add_hline(y=-180, line=dotted, row=2, col=1)
    picture.update_xaxes(type="log")
    picture.update_xaxes(title_text="frequency (Hz)", row=2, col=1)
    picture.update_yaxes(title_text=f"|{what}| (dB)", row=1, col=1)
    picture.update_yaxes(title_text=f"phase of {what} (deg)", row=2, col=1)
    title = "Open loop" if what == "L" else "From what is excited to what is observed"
    return _laid_out(picture, title, HEIGHT + 160)


def nyquist(curves: Sequence[Curve]) -> Any:
    """Return L in the complex plane around -1 with the circle it does not enter."""
    import plotly.graph_objects as go

    picture = go.Figure()
    for i, curve in enumerate(curves):
        _add_locus(picture, curve.open, i)
        if curve.style != "traced":
            radius = 1 / np.max(np.abs(curve.S))
            turn = np.linspace(0, 2 * np.pi, 121)
            picture.add_scatter(
                x=-1 + radius * np.cos(turn),
                y=radius * np.sin(turn),
                line={"color": FAILED, "dash": "dash", "width": 1},
                name=f"modulus margin {radius:.3g}",
            )
    return _around_minus_one(picture, "Nyquist", "L")


def generalised_nyquist(loci: Sequence[Trace]) -> Any:
    """Return the eigenvalues of L around -1, whose product 1 + each is det(I + L)."""
    import plotly.graph_objects as go

    picture = go.Figure()
    for i, locus in enumerate(loci):
        _add_locus(picture, locus, i)
    return _around_minus_one(
        picture, "Generalised Nyquist: the eigenvalues of L", "an eigenvalue"
    )


def _add_locus(picture: Any, trace: Trace, number: int) -> None:
    picture.add_scatter(
        x=trace.values.real,
        y=trace.values.imag,
        line=_line(trace.style, number=number),
        name=trace.name,
        text=[f"{hz:.4g} Hz" for hz in trace.hz],
    )


def _around_minus_one(picture: Any, title: str, what: str) -> Any:
    picture.add_scatter(
        x=[-1], y=[0], mode="markers", marker={"color": FAILED}, name="-1"
    )
    picture.update_xaxes(range=[-3.5, 1.5], title_text=f"real part of {what}")
    picture.update_yaxes(range=[-2, 2], title_text="imaginary part", scaleanchor="x")
    return _laid_out(picture, title, HEIGHT + 100)


def sensitivity(curves: Sequence[Curve], borders: Mapping[str, float]) -> Any:
    """Return |S| and |T| (dB) with the levels that are expected."""
    import plotly.graph_objects as go

    picture = go.Figure()
    for i, curve in enumerate(curves):
        for name, values, dash in (("S", curve.S, "solid"), ("T", curve.T, "dot")):
            picture.add_scatter(
                x=curve.hz,
                y=_db(values),
                line=_line(curve.style, dash, i),
                name=f"{name} {curve.name}",
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
