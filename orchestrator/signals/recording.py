"""A file of signals as a component: what is asked of it, and its FMU."""

from dataclasses import dataclass
from fractions import Fraction
from math import floor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from fmus.cache import digest
from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import rate as rate_text
from orchestrator.quantities.quantity import time_text
from orchestrator.signals.columns import Columns, read_columns
from orchestrator.signals.ticks import Interpolation, Rows, rows_of, ticks, values_at

if TYPE_CHECKING:
    from fmus.signals.build import Table

__all__ = ["AtEnd", "Interpolation", "Played", "Recording", "play"]

AtEnd: TypeAlias = Literal["hold", "end"]
MOST = 200_000_000  # numbers of a table


@dataclass(frozen=True)
class Recording:
    """What of a file is played: every ``step`` s, tick k as it is at ``begin`` +
    ``offset`` + k ``step`` (s, of the file).

    ``begin`` is the file's time at the run's t = 0, ``offset`` the run's time of the
    first tick.  ``rate`` is the exact period (s) of its rows; without ``step`` they
    are played as they stand.
    """

    file: Path
    step: Fraction | None = None
    interpolation: Interpolation = "hold"
    begin: Fraction = Fraction(0)
    rate: Fraction | None = None
    offset: Fraction = Fraction(0)

    @property
    def first(self) -> Fraction:
        """The file's time (s) at the first tick."""
        return self.begin + self.offset


@dataclass(frozen=True)
class Played:
    """The FMU of a recording, its period (s), and the run's time (s) at its last row.

    ``content`` is the SHA-256 of the file.
    """

    fmu: Path
    period: Fraction
    last: Fraction
    content: str


_read: dict[tuple[Path, str, Fraction | None], tuple[Columns, Rows]] = {}


def play(recording: Recording, **options: Any) -> Played:
    """Return the FMU of a recording, built once; ``options`` as of ``build_signals``.

    Raises:
        ScenarioError: the file cannot be read, its rows are not evenly spaced and no
            step says how to play them, or it begins after ``begin``.
        fmus.build.BuildError: a column has a name that no FMU can give it.
    """
    from fmus.signals.build import build_signals

    content = digest(recording.file) if recording.file.is_file() else ""
    columns, rows = _opened(recording, content)
    period = recording.step or rows.period
    if period is None:
        raise ScenarioError(
            f"{recording.file}: its rows are not evenly spaced; say how often it is "
            f'played, e.g. step = "1/1000"'
        )
    if rows.time(0) > recording.first:
        raise ScenarioError(
            f"{recording.file}: its first row is at {float(rows.time(0)):g} s; say "
            f'which of its times is the run\'s 0, e.g. begin = "{rows.time(0)}"'
        )
    if rows.time(-1) < recording.first:
        raise ScenarioError(
            f"{recording.file}: ends at {float(rows.time(-1)):g} s, before its first "
            f"tick at {float(recording.first):g} s of the file (begin and offset)"
        )
    last = rows.time(-1) - recording.begin
    told = (
        *(content, recording.interpolation, recording.begin, recording.offset),
        *(recording.rate, period),
    )
    fmu = build_signals(
        model_name(recording.file),
        told,
        lambda: table(recording, columns, rows, period, content),
        **options,
    )
    return Played(fmu, period, last, content)


def _opened(recording: Recording, content: str) -> tuple[Columns, Rows]:
    key = recording.file, content, recording.rate
    if key not in _read:
        _read.clear()  # one file is kept, which may be large
        columns = read_columns(recording.file)
        _read[key] = columns, rows_of(columns, recording.rate)
    return _read[key]


def table(
    recording: Recording,
    columns: Columns,
    rows: Rows,
    period: Fraction,
    content: str,
) -> "Table":
    """Return the values of every tick up to the last row, and one after it.

    Raises:
        ScenarioError: there would be too many.
    """
    from fmus.signals.build import Table

    last = (rows.time(-1) - recording.first) / period
    count = floor(last) + 1 + (last.denominator != 1)
    if count * len(columns.values) > MOST:
        raise ScenarioError(
            f"{recording.file}: {count} ticks of {len(columns.values)} columns are "
            f"more than {MOST} numbers; take fewer, or a longer step"
        )
    found = ticks(rows, period, recording.first, count)
    values = [
        values_at(column, found, recording.interpolation)
        for column in columns.values.values()
    ]
    names = tuple(columns.values)
    text = (
        f"Signals of {recording.file.name}\n\n"
        f"{columns.rows} rows, played every {rate_text(period)} from t = "
        f"{time_text(recording.offset)} on, which is "
        f"{time_text(recording.first)} s in the file; between rows "
        f"{_BETWEEN[recording.interpolation]}; after the last row its values hold.\n"
        f"SHA-256 of the file: {content}\n"
    )
    about = tuple(f"{name} of {recording.file.name}" for name in names)
    units = tuple(columns.units[name] for name in names)
    return Table(names, units, about, np.column_stack(values), period, text)


_BETWEEN = {"hold": "the one before holds", "linear": "the straight line"}


def model_name(file: Path) -> str:
    """Return a name for the FMU of a file."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in file.stem)
    return plain if plain and not plain[0].isdigit() else f"signals_{plain}"
