"""The columns of a file of recorded signals, with their units.

``.csv``      a header ``t [s], F [N], ...``; comma, semicolon or tab between
``.parquet``  columns so named, or with ``unit`` in their metadata, as our runs have
``.mat``      vectors of one length, or a trajectory as we, Dymola and OpenModelica
              write it

The time is called ``t`` or ``time``, in a unit of time, or in none and means seconds.
A column without unit is a number (``1``).
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import SECONDS
from orchestrator.quantities.unit import unit_of

TIME = ("t", "time")
EXACT = 2**53  # whole numbers up to it are doubles
_HEAD = re.compile(r"\s*(?P<name>.*?)\s*(?:\[(?P<unit>.*)\]|\((?P<other>.*)\))?\s*")


@dataclass(frozen=True)
class Columns:
    """Signals of one file: ``values`` by name, each (rows,), and their units.

    ``time`` holds numbers in ``time_unit``, one of ``SECONDS``, or is None where the
    file has none.
    """

    file: Path
    values: dict[str, NDArray[np.float64]]
    units: dict[str, str]
    time: NDArray[np.float64] | None = None
    time_unit: str = "s"

    @property
    def rows(self) -> int:
        return len(next(iter(self.values.values())))


def read_columns(file: Path) -> Columns:
    """Return what a file of signals holds.

    Raises:
        ScenarioError: no such file or form, a cell that is no finite real number, a
            whole number that no double holds, a unit that is none, columns of different
            lengths, or several that may be the time.
    """
    form = FORMS.get(file.suffix.lower())
    if form is None:
        known = ", ".join(FORMS)
        raise ScenarioError(f"{file}: signals are read from {known}")
    if not file.is_file():
        raise ScenarioError(f"{file}: no such file")
    try:
        found = list(form(file))
    except (OSError, ValueError, NotImplementedError) as error:
        raise ScenarioError(f"{file}: cannot be read: {error}") from None
    values: dict[str, NDArray[np.float64]] = {}
    units: dict[str, str] = {}
    for name, unit, column in found:
        if name in values:
            raise ScenarioError(f"{file}: {name} heads two columns")
        values[name], units[name] = _numbers(file, name, column), unit
        _check_unit(file, name, unit)
    if len({len(column) for column in values.values()}) > 1:
        raise ScenarioError(f"{file}: its columns are of different lengths")
    clock = _clock(file, units)
    time = None if clock is None else values.pop(clock)
    time_unit = "s" if clock is None or units[clock] == "1" else units[clock]
    units.pop(clock or "", None)
    if not values or not len(next(iter(values.values()))):
        raise ScenarioError(f"{file}: holds no rows of signals")
    return Columns(file, values, units, time, time_unit)


def _clock(file: Path, units: Mapping[str, str]) -> str | None:
    """Return the name of the column of times, None where there is none.

    One with a unit of time goes before one without, ``t`` and ``time`` before other
    cases of them; a ``T`` in another unit is a temperature or a torque.

    Raises:
        ScenarioError: several may be meant, or its unit is none of time.
    """
    named = [n for n in units if n.lower() in TIME]
    timed = [n for n in named if units[n] in SECONDS]
    found = [n for n in timed if n in TIME] or timed
    found = found or [n for n in named if units[n] == "1"]
    if len(found) > 1:
        raise ScenarioError(
            f"{file}: {' and '.join(found)} may each be the time; call one alone t or "
            f"time, with a unit of time, as in t [s]"
        )
    other = [n for n in named if n != "T" and units[n] not in (*SECONDS, "1")]
    if other and not found:
        raise ScenarioError(
            f"{file}: {other[0]} [{units[other[0]]}]: {units[other[0]]!r} is no unit "
            f"of time; write one of {', '.join(SECONDS)}, or call it otherwise if it "
            f"is no time"
        )
    return found[0] if found else None


def _numbers(file: Path, name: str, column: Any) -> NDArray[np.float64]:
    given = np.asarray(column).reshape(-1)
    if np.iscomplexobj(given):
        _refuse(file, name, given, given.imag != 0, "is complex")
        given = given.real
    if given.dtype.kind in "iu":
        beyond = (given > EXACT) | (given < -EXACT)
        beyond[beyond] = [int(float(n)) != n for n in given[beyond].tolist()]
        _refuse(file, name, given, beyond, "has more digits than a double holds (2^53)")
    numbers = given.astype(float)
    _refuse(file, name, numbers, ~np.isfinite(numbers), "is no finite number")
    return numbers


def _refuse(
    file: Path, name: str, cells: Any, bad: NDArray[np.bool_], why: str
) -> None:
    rows = np.flatnonzero(bad)
    if len(rows):
        raise ScenarioError(
            f"{file}: {name} is {cells[rows[0]]} in row {rows[0] + 1}, which {why}; "
            f"{len(rows)} of its cells are so"
        )


def _check_unit(file: Path, name: str, unit: str) -> None:
    try:
        unit_of(unit)
    except UnitError as error:
        raise ScenarioError(f"{file}: {name} [{unit}]: {error}") from None


def _headed(text: str) -> tuple[str, str]:
    match = _HEAD.fullmatch(text)
    assert match is not None
    return match["name"], (match["unit"] or match["other"] or "1").strip() or "1"


def _csv(file: Path) -> Iterator[tuple[str, str, Any]]:
    from pyarrow import csv, float64

    with file.open(encoding="utf-8-sig") as opened:
        head, first = opened.readline(), opened.readline()
    delimiter = next((d for d in (";", "\t") if d in head), ",")
    point = "," if delimiter != "," and "," in first else "."
    parse = csv.ParseOptions(delimiter=delimiter)
    names = csv.open_csv(file, parse_options=parse).schema.names
    if not any(_headed(name)[0].lower() in TIME for name in names):
        _refuse_empty_line(file)
    convert = csv.ConvertOptions(
        column_types={name: float64() for name in names}, decimal_point=point
    )
    table = csv.read_csv(file, parse_options=parse, convert_options=convert)
    for name, column in zip(table.column_names, table.columns, strict=True):
        yield *_headed(name), _arrow(column)


def _refuse_empty_line(file: Path) -> None:
    """Raise ``ScenarioError`` for an empty line that rows follow: without times, they
    would all be one row early."""
    empty, headed = 0, False
    with file.open(encoding="utf-8-sig") as opened:
        for number, line in enumerate(opened, 1):
            if line != "\n" and empty:
                raise ScenarioError(
                    f"{file}: line {empty} is empty, a missing cell; write the number "
                    f"of that row, or remove the line if there is no such row"
                )
            empty = empty or (number if headed and line == "\n" else 0)
            headed = headed or line != "\n"


def _parquet(file: Path) -> Iterator[tuple[str, str, Any]]:
    import pyarrow.parquet

    with pyarrow.parquet.ParquetFile(file) as parquet:
        table = parquet.read()
    for field, column in zip(table.schema, table.columns, strict=True):
        name, unit = _headed(field.name)
        told = (field.metadata or {}).get(b"unit")
        yield name, told.decode() if told else unit, _arrow(column)


def _arrow(column: Any) -> NDArray[np.float64]:
    from pyarrow import float64

    whole = column.cast(float64()).fill_null(np.nan)
    chunks = [np.from_dlpack(chunk) for chunk in whole.chunks]
    return np.concatenate(chunks) if chunks else np.empty(0)


def _mat(file: Path) -> Iterator[tuple[str, str, Any]]:
    from scipy.io import loadmat

    content = loadmat(file, appendmat=False)
    if "dataInfo" in content:
        yield from _trajectory(content)
        return
    for name, value in content.items():
        if not name.startswith("__") and np.ndim(value) == 2 and 1 in value.shape:
            yield name, "1", value


def _trajectory(content: dict[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Yield the columns of the table with time that changes."""
    info = content["dataInfo"]
    if np.any(info[0, 1:] > 2):
        raise ValueError("a trajectory of several rates; export one with --at")
    rows = content["data_2"]
    for i in range(info.shape[1]):
        texts = (content[key][:, i] for key in ("name", "description"))
        name, about = ("".join(text).strip() for text in texts)
        unit = re.search(r"\[([^\]|:]+)[^\]]*\]\s*$", about)
        if info[0, i] in (0, 2):
            place = int(info[1, i])
            yield name, unit[1] if unit else "1", np.sign(place) * rows[abs(place) - 1]


FORMS: dict[str, Callable[[Path], Iterator[tuple[str, str, Any]]]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".mat": _mat,
}
