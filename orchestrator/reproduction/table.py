"""Tables of a source, written as it prints them: rows, columns, and rules.

A ``[[table]]`` of ``reference.toml``::

    title = "Average of 20 experiments, heavy payload"
    where = "Table 5-2"
    id = "step.heavy.{c}.{h}.{q}@{ours}"
    metric = "x.{q}"
    set = ["reference.height={h}"]
    class = "calibrated"
    columns = [{ name = "Controller 1", c = "c1" }, { name = "Controller 2", c = "c2" }]
    rows = [
      { name = "rise, 100 um", h = "1e-4", q = "rise", published = [0.0239, 0.01454] },
    ]
    ours = [
      { name = "cal", scenario = "step_cal", expected = [[0.0242, 0.0158]] },
      { name = "tab", scenario = "step" },
    ]

Every key of a figure may stand at the table, at a row, at a column, at one of
``ours`` (several ways to compute the same cell; one without) or at ``except.<id>``;
the later of these counts, ``set`` adds up.  Every other key fills the ``{key}`` of
the texts, ``{row}``, ``{column}`` and ``{ours}`` are the names; a text that is one
``{key}`` and nothing else takes the value as it is.

``published`` and ``expected`` of a row are lists along the columns; ``expected`` of
one of ``ours`` is a list of such lists.  ``""`` is nothing published or expected,
``"-"`` no figure at all.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from orchestrator.errors import did_you_mean

PLACE = re.compile(r"\{(\w+)\}")
OWN = ("title", "rows", "columns", "ours", "except")
LISTED = ("published", "expected")
MERGED = ("arguments", "with")


class TableError(ValueError):
    """A table that says something wrong, with its title."""


@dataclass(frozen=True)
class Table:
    """How a source's table is laid out; ``ids[row][column]`` has one id per ours."""

    title: str
    where: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    ours: tuple[str, ...]
    ids: tuple[tuple[tuple[str | None, ...], ...], ...]


Level: TypeAlias = Mapping[str, Any]


def expand(written: Level, known: set[str]) -> tuple[Table, list[dict[str, Any]]]:
    """Return a table's layout and its figures; ``known`` are the keys of a figure.

    Raises:
        TableError: a key is unknown, missing or never used, or a list does not fit.
    """
    title = str(written.get("title", written.get("where", "")))
    try:
        return _expand(written, known, title)
    except TableError as error:
        raise TableError(f"table {title!r}: {error}") from None


def _expand(
    written: Level, known: set[str], title: str
) -> tuple[Table, list[dict[str, Any]]]:
    for key in written:
        if key not in known and key not in OWN:
            remedy = did_you_mean(key, [*known, *OWN])
            raise TableError(f"there is no key {key!r}; {remedy}")
    rows, columns = _levels(written, "rows"), _levels(written, "columns")
    ours = _levels(written, "ours") if "ours" in written else [{"name": "ours"}]
    base = {key: value for key, value in written.items() if key in known}
    exceptions = dict(written.get("except", {}))
    used = {"name"}
    figures: list[dict[str, Any]] = []

    def cell(i: int, j: int, way: Level) -> str | None:
        places = ((i, j), (j,), (i,), (i, j))
        levels = (base, rows[i], columns[j], way)
        texts = _texts(levels[1:], known)
        fields = _merged(levels, places, (len(rows), len(columns)), known)
        if fields is None:
            return None
        filled = {key: _filled(value, texts, used) for key, value in fields.items()}
        name = str(filled.get("id", ""))
        figures.append(filled | exceptions.pop(name, {}))
        return name

    ids = tuple(
        tuple(tuple(cell(i, j, way) for way in ours) for j in range(len(columns)))
        for i in range(len(rows))
    )
    for name in exceptions:
        raise TableError(f"except: it has no figure {name!r}")
    for level in (*rows, *columns, *ours):
        for key in level:
            if key not in known and key not in used:
                raise TableError(
                    f"{level.get('name')!r} gives {key!r}: nothing uses it"
                )
    names = [tuple(str(level.get("name", "")) for level in x) for x in (rows, columns)]
    ways = tuple(str(way.get("name", "")) for way in ours)
    where = str(written.get("where", ""))
    return Table(title, where, names[0], names[1], ways, ids), figures


def _levels(written: Level, key: str) -> list[dict[str, Any]]:
    found = written.get(key)
    if not isinstance(found, list) or not found:
        raise TableError(f"{key} is missing: a list of {{ name = ... }}")
    if not all(isinstance(level, dict) for level in found):
        raise TableError(f"{key}: each is a {{ name = ... }}")
    return found


def _texts(levels: Sequence[Level], known: set[str]) -> dict[str, Any]:
    """Return what fills the places in the texts of one cell."""
    texts: dict[str, Any] = {}
    for kind, level in zip(("row", "column", "ours"), levels, strict=True):
        texts |= {key: value for key, value in level.items() if key not in known}
        texts[kind] = level.get("name", "")
    return texts


def _merged(
    levels: Sequence[Level],
    places: Sequence[tuple[int, ...]],
    shape: tuple[int, int],
    known: set[str],
) -> dict[str, Any] | None:
    """Return the keys of one cell's figure; None if there is none."""
    shapes = (shape, shape[1:], shape[:1], shape)
    fields: dict[str, Any] = {}
    for level, place, lengths in zip(levels, places, shapes, strict=True):
        for key in known & level.keys():
            value = level[key]
            if key in LISTED:
                value = _picked(key, value, place, lengths)
            elif key == "set":
                value = [*fields.get("set", ()), *value]
            elif key in MERGED:
                value = {**fields.get(key, {}), **value}
            fields[key] = value
    if "-" in (fields.get("published"), fields.get("expected")):
        return None
    if fields.get("expected", "") == "":
        fields.pop("expected", None)
        fields.pop("tolerance", None)
    if fields.get("published") == "":
        del fields["published"]
    return fields


def _picked(key: str, value: Any, place: Sequence[int], lengths: Sequence[int]) -> Any:
    """Return a cell's own value of lists along rows or columns."""
    for at, length in zip(place, lengths, strict=True):
        if not isinstance(value, list):
            return value
        if len(value) != length:
            raise TableError(f"{key} has {len(value)} values for {length}: {value}")
        value = value[at]
    return value


def _filled(value: Any, texts: Mapping[str, Any], used: set[str]) -> Any:
    """Fill the ``{places}`` in every text of a value."""
    if isinstance(value, dict):
        return {key: _filled(of, texts, used) for key, of in value.items()}
    if isinstance(value, list):
        return [_filled(of, texts, used) for of in value]
    if not isinstance(value, str):
        return value

    def text(match: re.Match[str]) -> Any:
        if match[1] not in texts:
            raise TableError(f"{value!r}: {match[0]}? {did_you_mean(match[1], texts)}")
        used.add(match[1])
        return texts[match[1]]

    whole = PLACE.fullmatch(value)
    return text(whole) if whole else PLACE.sub(lambda match: str(text(match)), value)
