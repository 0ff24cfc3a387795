"""What all pictures share: their colours, in light, dark and print, and texts.

A picture is one ``<svg>`` that stands in a file of its own or in a page.
"""

from collections.abc import Iterable, Sequence
from html import escape

SIZE = 13.0  # of the text, in pixels
LINE = 17.0  # from one line of text to the next
_NARROW, _WIDE = set("ijlIftr.,:;|'()[]{} /-"), set("mwMWQO%@→×")

_LIGHT = (
    "--paper:#fff;--ink:#22262b;--soft:#59616b;--line:#8a929c;--grid:#e3e7ec;"
    "--box:#f3f6fa;--edge:#1f5fa8;--aged:#b3470e;--held:#8a5a00;--bad:#b3263c;"
    "--hold-a:#bcd3ee;--hold-b:#dfeaf7;--step-a:#c9e2d3;--step-b:#e4f1e9"
)
_DARK = (
    "--paper:#171a1e;--ink:#e7eaee;--soft:#a9b1bb;--line:#7d8691;--grid:#2e343b;"
    "--box:#22272e;--edge:#7fb2ee;--aged:#f0965c;--held:#e3b45a;--bad:#f07a8c;"
    "--hold-a:#2f5784;--hold-b:#243c58;--step-a:#2f6447;--step-b:#264636"
)
_STYLE = (
    f".fd{{{_LIGHT}}}@media screen and (prefers-color-scheme:dark){{.fd{{{_DARK}}}}}"
    ".fd text{font:13px system-ui,sans-serif;fill:var(--ink)}"
    ".fd .name{font-weight:600}.fd .soft{fill:var(--soft)}.fd .small{font-size:11.5px}"
    ".fd .aged{fill:var(--aged)}.fd .held{fill:var(--held)}.fd .bad{fill:var(--bad)}"
    ".fd .tie{fill:var(--edge)}"
    ".fd .halo{paint-order:stroke;stroke:var(--paper);stroke-width:4px;"
    "stroke-linejoin:round}"
)


def picture(width: float, height: float, title: str, parts: Iterable[str]) -> str:
    """Return a whole picture of that size (pixels); the title is read aloud."""
    w, h = f"{width:.0f}", f"{height:.0f}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="fd" role="img" '
        f'viewBox="0 0 {w} {h}" width="{w}" height="{h}">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style>"
        f'<rect width="{w}" height="{h}" fill="var(--paper)"/>{"".join(parts)}</svg>\n'
    )


def text(
    x: float, y: float, said: str, look: str = "", anchor: str = "start", tip: str = ""
) -> str:
    """Return a line of text; ``tip`` is shown where the mouse rests."""
    told = f"<title>{escape(tip)}</title>" if tip else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" class="{look}" text-anchor="{anchor}">'
        f"{told}{escape(said)}</text>"
    )


def line(points: Sequence[tuple[float, float]], colour: str, more: str = "") -> str:
    """Return straight lines through points."""
    drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{drawn}" fill="none" stroke="var(--{colour})" {more}/>'


def box(
    x: float, y: float, w: float, h: float, fill: str, more: str = "", tip: str = ""
) -> str:
    """Return a rectangle."""
    told = f"<title>{escape(tip)}</title>" if tip else ""
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" '
        f'fill="var(--{fill})" {more}>{told}</rect>'
    )


def arrow_heads(*colours: str) -> str:
    """Return what ``head`` refers to."""
    return "<defs>{}</defs>".format(
        "".join(
            f'<marker id="fd-{c}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" '
            f'markerHeight="8" markerUnits="userSpaceOnUse" orient="auto">'
            f'<path d="M0,0.6L8,4L0,7.4z" fill="var(--{c})"/></marker>'
            for c in colours
        )
    )


def head(colour: str) -> str:
    """Return the attribute by which a line ends in an arrow."""
    return f'marker-end="url(#fd-{colour})"'


def width_of(said: str, size: float = SIZE) -> float:
    """Return how wide a text is at most in the fonts that systems have."""
    letters = sum(
        0.36 if c in _NARROW else 1.0 if c in _WIDE else 0.72 if c.isupper() else 0.62
        for c in said
    )
    return letters * size


def shortened(said: str, letters: int) -> str:
    """Return the end of a name that is too long."""
    return said if len(said) <= letters else f"…{said[1 - letters :]}"
