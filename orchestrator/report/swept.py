"""The page of a sweep: each figure over what was varied, with the expected border.

Two varied keys give heat maps, one gives lines, more (or a sample) give points
over each key in turn.
"""

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from orchestrator.evaluation.schema import Expectation
from orchestrator.quantities.quantity import Quantity
from orchestrator.report.shell import shown, written

HEIGHT = 420
FAILED = "#d1495b"
HELD = "#2f78c4"


def write_swept(
    name: str,
    keys: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    units: Mapping[str, str],
    expect: Mapping[str, Expectation],
    words: Sequence[str],
    path: Path,
) -> Path:
    """Write the page and return its path; ``words`` are said above the pictures."""
    told = [f"<p>{escape(line)}</p>" for line in words]
    pictures = _pictures(keys, rows, units, expect)
    return written(name, [*told, *map(shown, pictures)], path, whole=True)


def _pictures(
    keys: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    units: Mapping[str, str],
    expect: Mapping[str, Expectation],
) -> Iterator[Any]:
    for name, unit in units.items():
        bounds = list(_bounds(expect.get(name), unit))
        grid = len(keys) == 2 and len(rows) == len(
            {row[keys[0]] for row in rows}
        ) * len({row[keys[1]] for row in rows})
        if grid:
            yield _heat_map(name, unit, keys, rows, bounds)
        elif keys:
            yield _points(name, unit, keys, rows, bounds)


def _bounds(expectation: Expectation | None, unit: str) -> Iterator[float]:
    if expectation is None:
        return
    given = [expectation.below, expectation.above]
    if expectation.near is not None and expectation.within is not None:
        given += [
            expectation.near - expectation.within,
            expectation.near + expectation.within,
        ]
    for bound in given:
        if bound is not None:
            yield Quantity(bound, expectation.unit or unit).to(unit).value


def _heat_map(
    name: str,
    unit: str,
    keys: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    bounds: Sequence[float],
) -> Any:
    import plotly.graph_objects as go

    x, y = (list(dict.fromkeys(row[key] for row in rows)) for key in keys)
    known = {(row[keys[0]], row[keys[1]]): row.get(name) for row in rows}
    z = [[known.get((a, b)) for a in x] for b in y]
    columns, lines = _labels(x), _labels(y)
    across, up = dict(zip(x, columns, strict=True)), dict(zip(y, lines, strict=True))
    picture = go.Figure(
        go.Heatmap(
            x=columns,
            y=lines,
            z=z,
            colorscale="Viridis",
            colorbar={"title": unit},
        )
    )
    broken = [
        (row[keys[0]], row[keys[1]])
        for row in rows
        if name in row["broken"] or row["failure"]
    ]
    picture.add_scatter(
        x=[across[a] for a, _ in broken],
        y=[up[b] for _, b in broken],
        mode="markers",
        marker={"symbol": "x", "color": FAILED, "size": 9},
        name="not met",
    )
    for bound in bounds:
        if all(isinstance(v, float) for v in (*x, *y)):
            picture.add_contour(
                x=x,
                y=y,
                z=z,
                contours={
                    "start": bound,
                    "end": bound,
                    "size": 1,
                    "coloring": "lines",
                },
                line={"width": 3},
                colorscale=[[0, FAILED], [1, FAILED]],
                showscale=False,
                name=f"expected border {bound:g} {unit}",
            )
    picture.update_layout(
        title=f"{name} ({unit})",
        xaxis_title=keys[0],
        yaxis_title=keys[1],
        height=HEIGHT,
        template="plotly_white",
        showlegend=False,
    )
    return picture


def _labels(values: Sequence[Any]) -> list[Any]:
    """Return numbers where all are, else texts: categories."""
    numbers = all(isinstance(v, float) for v in values)
    return list(values) if numbers else [str(v) for v in values]


def _points(
    name: str,
    unit: str,
    keys: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    bounds: Sequence[float],
) -> Any:
    from plotly.subplots import make_subplots

    picture = make_subplots(cols=len(keys), shared_yaxes=True, horizontal_spacing=0.03)
    line = len(keys) == 1 and len(rows) < 200
    for i, key in enumerate(keys, 1):
        colours = [
            FAILED if name in row["broken"] or row["failure"] else HELD for row in rows
        ]
        picture.add_scatter(
            x=_labels([row[key] for row in rows]),
            y=[row.get(name) for row in rows],
            mode="lines+markers" if line else "markers",
            line={"color": "#9db7d6"},
            marker={"color": colours, "size": 6 if len(rows) < 1000 else 3},
            showlegend=False,
            row=1,
            col=i,
        )
        picture.update_xaxes(title_text=key, row=1, col=i)
    for bound in bounds:
        picture.add_hline(
            y=bound,
            line={"color": FAILED, "dash": "dash"},
            annotation_text=f"expected {bound:g}",
        )
    picture.update_yaxes(title_text=unit, row=1, col=1)
    picture.update_layout(
        title=f"{name} ({unit})", height=HEIGHT, template="plotly_white"
    )
    return picture
