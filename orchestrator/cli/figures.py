"""How ``reproduce`` prints a study: counts first, then its tables, then single figures.

A table of the source keeps its rows and columns; each cell has the published figure
and ours side by side, ours with a mark for its verdict.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from orchestrator.cli.output import echo, print_table
from orchestrator.reproduction.published import Statement, Verdict
from orchestrator.reproduction.reproduce import Reproduction
from orchestrator.reproduction.table import Table
from orchestrator.reproduction.verdict import CLASSES, MEANING, Figure, summary

MARKS: dict[Verdict, str] = {
    "agrees": "=",
    "differs": "/=",
    "contradicts": "!",
    "computed": ".",
    "out of reach": "?",
}


def print_reproduction(study: str, done: Reproduction) -> None:
    """Print counts, then published and own figures side by side, and the reasons."""
    _print_counts(study, done)
    figures = {figure.spec.id: figure for figure in done.figures}
    agreement = done.reference.agreement
    for table in done.reference.tables:
        names = [name for row in table.ids for cell in row for name in cell if name]
        inside = {name: figures.pop(name) for name in names if name in figures}
        if inside:
            _print_source_table(table, inside)
            _print_notes(list(inside.values()), agreement, _groups(table))
    if figures:
        echo("\nsingle figures")
        _print_single(list(figures.values()), agreement)
        _print_notes(list(figures.values()), agreement, {})


def _print_counts(study: str, done: Reproduction) -> None:
    counted = summary(done.figures)
    echo(f"{study}: {done.reference.title}\n{done.reference.source}")
    rows = []
    for verdict, meaning in MEANING.items():
        of = counted["verdicts"][verdict]
        numbers = [str(of[kind] or "") for kind in CLASSES]
        mark = MARKS[verdict]
        rows.append([mark, verdict, *numbers, str(sum(of.values())), meaning])
    head = ["", "verdict", *(f">{kind}" for kind in CLASSES), ">all", "means"]
    print_table(head, rows)
    regression = counted["regression"]
    echo(
        f"{counted['figures']} figures; a number agrees within "
        f"{100 * done.reference.agreement:g} % where no other agreement is shown; "
        "in tables ours stand right of the published\n"
        f"regression against our own acceptance values: {regression['holds']} hold, "
        f"{regression['FAILED']} FAILED, {regression['not expected']} without one"
    )


def _groups(table: Table) -> dict[str, set[str]]:
    """Return the ids of each row, column and way of ours, by its name."""
    cells = [cell for row in table.ids for cell in row]
    lines = [
        *zip(table.rows, table.ids, strict=True),
        *zip(table.columns, zip(*table.ids, strict=True), strict=True),
        *((way, [(c[w],) for c in cells]) for w, way in enumerate(table.ours)),
    ]
    return {name: {one for cell in line for one in cell if one} for name, line in lines}


def _print_source_table(table: Table, figures: Mapping[str, Figure]) -> None:
    """Print a table as the source lays it out; ours stand right of the published."""
    specs = [figure.spec for figure in figures.values()]
    units = {spec.unit for spec in specs}
    one_unit = _unit(next(iter(units))) if len(units) == 1 else ""
    published = {str(spec.obtained) for spec in specs if spec.published is not None}
    classes = {spec.class_ for spec in specs}
    told = (one_unit, ", ".join(sorted(published)), ", ".join(sorted(classes)))
    where = f"{table.where}: " * (table.where != "-")
    echo(f"\n{where}{table.title} ({'; '.join(filter(None, told))})")
    groups = _groups(table)
    of = {name: _common_unit(ids, figures) for name, ids in groups.items()}
    in_head = len(units) > 1 and all(of[column] is not None for column in table.columns)
    in_name = len(units) > 1 and not in_head
    head = [""]
    rows = [[n + (of[n] or "") * in_name] for n in table.rows]
    for j, column in enumerate(table.columns):
        ways = [
            w for w in range(len(table.ours)) if any(row[j][w] for row in table.ids)
        ]
        head.append(f">{column}" + (of[column] or "") * in_head)
        head += [f">{table.ours[w]}" for w in ways]
        for name, ids, row in zip(table.rows, table.ids, rows, strict=True):
            found = [figures.get(ids[j][w] or "") for w in ways]
            first = next((figure for figure in found if figure is not None), None)
            with_unit = in_name and of[name] is None
            row.append("" if first is None else _published(first, with_unit))
            row += ["" if figure is None else _ours(figure) for figure in found]
    print_table(head, [row for row in rows if any(row[1:])])


def _common_unit(ids: set[str], figures: Mapping[str, Figure]) -> str | None:
    """Return the unit of a row or column in brackets; None if it has several."""
    units = {_unit(figures[name].spec.unit) for name in ids & figures.keys()}
    if len(units) > 1:
        return None
    return "".join(f" ({unit})" for unit in units if unit)


def _ours(figure: Figure) -> str:
    failed = " FAILED" if figure.regression == "FAILED" else ""
    value = "" if figure.value is None else f"{figure.value:.4g} "
    return f"{value}{MARKS[figure.verdict]:<2}{failed}"


def _published(figure: Figure, with_unit: bool) -> str:
    """Return what a cell shows of the source: a number, a bound, or its words."""
    published, unit = figure.spec.published, _unit(figure.spec.unit)
    if published is None or isinstance(published, str):
        return published or ""
    if isinstance(published, Statement) and published.other is not None:
        return f'"{published.says}"' if published.says else str(published)
    number = f"{published:.6g}" if isinstance(published, float) else str(published)
    said = published.says if isinstance(published, Statement) else ""
    return " ".join(filter(None, (number, unit * with_unit, said and f'"{said}"')))


def _print_single(figures: Iterable[Figure], agreement: float) -> None:
    rows = []
    for f in figures:
        difference = ""
        if f.difference is not None:
            difference = f"{f.difference:+.3g}"
            if isinstance(f.spec.published, float) and f.spec.published:
                difference += f" ({100 * f.difference / f.spec.published:+.1f} %)"
        ours = "" if f.value is None else f"{f.value:.6g}"
        own = "" if f.agreement == agreement else f" within {100 * f.agreement:g} %"
        kind = f"{f.spec.class_}, {f.spec.obtained}" * (f.spec.published is not None)
        row = [f.spec.id, f.spec.where, _published(f, False), ours, _unit(f.spec.unit)]
        verdict = f.verdict + own * (f.verdict in ("agrees", "differs"))
        regression = f.regression or ""
        rows.append([*row, difference, kind or f.spec.class_, verdict, regression])
    head = ["figure", "where", ">published", ">ours", "unit", ">difference"]
    print_table([*head, "class, obtained", "verdict", "regression"], rows)


def _print_notes(
    figures: Sequence[Figure], agreement: float, groups: Mapping[str, set[str]]
) -> None:
    """Print each reason once, with the rows, columns or figures it is given for."""
    notes: dict[str, list[str]] = {}
    for figure in figures:
        if figure.why:
            notes.setdefault(figure.why, []).append(figure.spec.id)
        if figure.agreement != agreement:
            text = f"judged within {100 * figure.agreement:g} %"
            notes.setdefault(text, []).append(figure.spec.id)
    shown = {figure.spec.id for figure in figures}
    for text, names in notes.items():
        rest, whole = {*names}, []
        for group, ids in groups.items():
            if ids & rest and ids & shown <= rest:
                whole.append(group)
                rest -= ids
        said = [*whole, _shortened([name for name in names if name in rest])]
        of = "; ".join(filter(None, said))
        echo("  " + (text if len(names) == len(figures) > 1 else f"{of}: {text}"))


def _shortened(names: Sequence[str]) -> str:
    """Return ids with what neighbours share said once: ``a.b.c, .d``."""
    parts = []
    for stem, group in groupby(names, lambda name: name.rpartition(".")[0]):
        endings = [name.removeprefix(stem) for name in group]
        parts.append(stem + ", ".join(endings))
    return ", ".join(parts)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit
