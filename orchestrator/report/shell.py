"""The page around what is shown: one for all reports, light, dark, narrow, printed.

It fetches nothing: Plotly lies in it, if something is drawn.  What draws lines alone
takes ``plotly/plotly-basic.min.js``, as it is published (4.1.1, MIT), a quarter of
the whole library in size and in the time that a browser needs to read it.
"""

import json
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

from orchestrator.report.embedded import recorded
from orchestrator.report.figure import Drawing

LINES = Path(__file__).parent / "plotly" / "plotly-basic.min.js"
CONFIG = {"displaylogo": False, "responsive": True}
STYLE = Path(__file__).parent / "page.css"
SCRIPT = Path(__file__).parent / "page.js"


def signals(drawing: Drawing) -> str:
    """Return curves over time that show every recorded point when they are zoomed."""
    plot = drawing.plot.to_html(
        full_html=False, include_plotlyjs=False, config=CONFIG, div_id="signals"
    )
    return f"{plot}{recorded(drawing.curves)}"


def shown(plot: Any) -> str:
    """Return a Plotly figure for a page."""
    text: str = plot.to_html(full_html=False, include_plotlyjs=False, config=CONFIG)
    return text


def folded(title: str, plot: Mapping[str, Any]) -> str:
    """Return a plot, ``data`` and ``layout`` as Plotly takes them, that is drawn when
    its title is opened, or printed."""
    content = json.dumps(plot).replace("<", "\\u003c")
    return (
        f"<details class=folded><summary>{escape(title)}</summary><div></div>"
        f'<script type="application/json">{content}</script></details>'
    )


def written(
    title: str, parts: Iterable[str], path: Path, *, whole: bool = False
) -> Path:
    """Write a page of these parts under its title and return its path.

    ``whole``: there is more to draw than lines, say a map of colours.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    body = "\n".join(parts)
    plotly = f"<script>{_plotly(whole)}</script>" if _draws(body) else ""
    style, script = (f.read_text(encoding="utf-8") for f in (STYLE, SCRIPT))
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{style}</style></head>"
        f"<body>{plotly}<main><h1>{escape(title)}</h1>\n{body}\n</main>"
        f"<script>{script}</script></body></html>\n",
        encoding="utf-8",
    )
    return path


def _draws(body: str) -> bool:
    return "Plotly." in body or "<details class=folded>" in body


def _plotly(whole: bool) -> str:
    from plotly.offline import get_plotlyjs

    text: str = get_plotlyjs() if whole else LINES.read_text(encoding="utf-8")
    return text
