"""The page around what is shown: one for all reports, light, dark, narrow, printed.

It fetches nothing: Plotly lies in it, once, in the first plot that is shown.
"""

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import Any

from orchestrator.report.embedded import recorded
from orchestrator.report.figure import Drawing

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


def written(title: str, parts: Iterable[str], path: Path) -> Path:
    """Write a page of these parts under its title and return its path."""
    from plotly.offline import get_plotlyjs

    path.parent.mkdir(parents=True, exist_ok=True)
    body = "\n".join(parts)
    plotly = f"<script>{get_plotlyjs()}</script>" if "Plotly." in body else ""
    style, script = (f.read_text(encoding="utf-8") for f in (STYLE, SCRIPT))
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{style}</style>{plotly}</head>"
        f"<body><main><h1>{escape(title)}</h1>\n{body}\n</main>"
        f"<script>{script}</script></body></html>\n",
        encoding="utf-8",
    )
    return path
