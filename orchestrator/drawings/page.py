"""Where a figure goes: a picture, or the page of a study with all of them."""

from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from orchestrator.drawings.making import Maker
from orchestrator.drawings.picture import as_svg, caption, picture, save
from orchestrator.drawings.registry import Drawn, Registry
from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.folders.temporary import temporary_folder
from orchestrator.reproduction.reproduce import Reproduction
from orchestrator.reproduction.verdict import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

FORMS = (".png", ".svg", ".html")
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 1200px; margin: 2rem auto;
  padding: 0 1rem; color: #22262b }
figure { margin: 2rem 0 } figure svg { max-width: 100%; height: auto }
figcaption { font-size: .9rem; color: #555 }
table { border-collapse: collapse; margin: .5rem 0 2rem; font-size: .85rem }
td, th { padding: .15rem .9rem .15rem 0; text-align: right }
td:first-child, th:first-child { text-align: left }
.differs, .contradicts { color: #b03a48 } .agrees { color: #2e8b57 }
"""


def write_figure(registry: Registry, number: str, file: Path) -> Path:
    """Draw one figure into a file, its form by the suffix, and return its path.

    Raises:
        FeedDriveError: the suffix is another, or a curve cannot be made.
    """
    if file.suffix not in FORMS:
        raise ScenarioError(f"{file}: write {', '.join(FORMS)}")
    drawn = registry.figure(number)
    with temporary_folder() as folder:
        made = _made(number, drawn, Maker(registry.folder, folder))
        if file.suffix == ".html":
            title = f"{caption(number)}: {drawn.title}"
            file.write_text(_page(title, _shown(drawn, as_svg(made))), encoding="utf-8")
        else:
            save(made, file)
    return file


def write_figures(
    registry: Registry,
    done: Reproduction,
    file: Path,
    told: Callable[[str], None] = lambda text: None,
) -> Path:
    """Write the page of a study: all its figures, then its tables, and return it.

    ``told`` hears of each figure that is drawn.

    Raises:
        FeedDriveError: a curve cannot be made.
    """
    known = {figure.spec.id: figure.value for figure in done.figures}
    parts = [f"<p>{escape(done.reference.source)}</p>"]
    with temporary_folder() as folder:
        maker = Maker(registry.folder, folder, known)
        for number, drawn in registry.figures.items():
            parts.append(_shown(drawn, as_svg(_made(number, drawn, maker))))
            told(number)
    parts += ["<h2>Not drawn</h2>", _reasons(registry.not_drawn)]
    parts += ["<h2>Tables</h2>", *_tables(done)]
    file.write_text(_page(done.reference.title, "\n".join(parts)), encoding="utf-8")
    return file


def _made(number: str, drawn: Drawn, maker: Maker) -> "Picture":
    try:
        return picture(number, drawn, maker)
    except FeedDriveError as error:
        raise type(error)(f"{number}: {error}") from error


def _page(title: str, body: str) -> str:
    return (
        f"<!doctype html><meta charset=utf-8><title>{escape(title)}</title>"
        f"<style>{STYLE}</style><h1>{escape(title)}</h1>{body}"
    )


def _shown(drawn: Drawn, svg: str) -> str:
    there = f"There {drawn.obtained}."
    return (
        f"<figure>{svg}<figcaption>{escape(drawn.title)}. {there} "
        f"{escape(drawn.why)}</figcaption></figure>"
    )


def _reasons(reasons: Mapping[str, str]) -> str:
    lines = (f"<li>{escape(caption(n))}: {escape(why)}" for n, why in reasons.items())
    return f"<ul>{''.join(lines)}</ul>"


def _tables(done: Reproduction) -> list[str]:
    figures = {figure.spec.id: figure for figure in done.figures}
    parts = []
    for table in done.reference.tables:
        head = "".join(
            f"<th>{escape(column)}<th>{'<th>'.join(map(escape, table.ours))}"
            for column in table.columns
        )
        rows = []
        for name, row in zip(table.rows, table.ids, strict=True):
            cells = ""
            for cell in row:
                found = [figures.get(one or "") for one in cell]
                first = next((f for f in found if f), None)
                published = "" if first is None else first.spec.published
                cells += f"<td>{escape('' if published is None else str(published))}"
                cells += "".join(
                    f"<td class={f.verdict.split()[0]!r}>{f.value:.4g}"
                    if f and f.value is not None
                    else "<td>"
                    for f in found
                )
            rows.append(f"<tr><td>{escape(name)}{cells}</tr>")
        units = {f.spec.unit for row in table.ids for c in row for f in _of(c, figures)}
        (unit,) = units if len(units) == 1 else ("1",)
        title = f"{table.where}: {table.title}" + f" ({unit})" * (unit != "1")
        parts.append(
            f"<h3>{escape(title)}</h3><table><tr><th>{head}</tr>{''.join(rows)}</table>"
        )
    return parts


def _of(cell: Sequence[str | None], figures: Mapping[str, Figure]) -> list[Figure]:
    return [figures[one] for one in cell if one is not None and one in figures]
