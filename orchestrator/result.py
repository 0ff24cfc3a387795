"""What was recorded: one table per row rate, with units and provenance."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FmuError, did_you_mean
from orchestrator.profile import Profile
from orchestrator.quantities.instants import Instants
from orchestrator.quantities.unit import Unit

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Signal:
    """One recorded variable: ``time`` (s) and ``values``, both (n,), and its unit.

    Rows between the instants at which it is ``published`` repeat the last value;
    None is for what does not change, or is not known.
    """

    name: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    unit: str
    published: Instants | None = None

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype=dtype, copy=copy)

    def __len__(self) -> int:
        return len(self.values)


@dataclass(frozen=True)
class Paced:
    """How well a run kept to the clock, at ``pace`` times real time.

    Of ``blocks`` of instants ``overruns`` were done later than the clock came to their
    last one; ``worst_s`` and ``rms_s`` are how late (s) blocks were over, the jitter.
    """

    pace: float
    blocks: int
    overruns: int
    worst_s: float
    rms_s: float

    def __str__(self) -> str:
        return (
            f"paced at {self.pace:g} x real time: {self.overruns:,} overruns in "
            f"{self.blocks:,} blocks, jitter {1e6 * self.rms_s:.0f} us rms, "
            f"{1e6 * self.worst_s:.0f} us at worst"
        )


@dataclass(frozen=True)
class Timing:
    """How long a run took: ``wall_s`` in all, instants executed, seconds simulated.

    ``executor`` is what carried them out; ``profile`` says where the time went and
    ``paced`` how the clock was kept, if that was asked for.
    """

    wall_s: float
    instants: int
    simulated_s: float
    executor: str
    profile: Profile | None = None
    paced: Paced | None = None

    @property
    def real_time_factor(self) -> float:
        return self.simulated_s / self.wall_s if self.wall_s > 0 else float("inf")

    @property
    def us_per_instant(self) -> float:
        return 1e6 * self.wall_s / self.instants if self.instants else 0.0


@dataclass(frozen=True)
class End:
    """Which component ended a run before its stop, at what time (s), and why."""

    by: str
    at: float
    reason: str

    def __str__(self) -> str:
        return f"ended by {self.by} at t = {self.at:.9g} s: {self.reason}"


class Result(Mapping[str, Signal]):
    """Recorded signals by name, read from the files of a run as they are asked for.

    ``result["plant.x_2"]`` is a ``Signal``, at its highest rate if there are several.
    ``folder`` holds the tables; ``timing`` is None when a result is opened again.
    ``ended`` says how an FMU ended the run before its stop, if one did.
    """

    def __init__(
        self,
        folder: Path,
        timing: Timing | None = None,
        ended: End | None = None,
        *,
        period: Fraction | None = None,
    ) -> None:
        self.folder = Path(folder)
        self.timing = timing
        self.ended = ended
        self._columns = _columns(self.folder, period)

    @property
    def periods(self) -> list[Fraction]:
        """Return the row periods there are (s), the shortest first."""
        return sorted({_period(file) for file in _files(self.folder / "result")})

    def at(self, period: Fraction) -> "Result":
        """Return what was recorded with that row period (s) alone."""
        return Result(self.folder, self.timing, self.ended, period=period)

    def __getitem__(self, name: str) -> Signal:
        try:
            file = self._columns[name]
        except KeyError:
            raise KeyError(
                f"{name} was not recorded; {did_you_mean(name, self._columns)}"
            ) from None
        table = _read(file, ["time", name])
        about = table.schema.field(name).metadata
        published = about.get(b"published")
        return Signal(
            name,
            _numbers(table["time"]),
            _numbers(table[name]),
            Unit.from_metadata(about),
            published and Instants.read(published.decode()),
        )

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self) -> "dict[str, pd.DataFrame]":
        """Return one data frame per row rate, indexed by time (needs pandas)."""
        files = _files(self.folder / "result")
        return {f.stem: _read(f).to_pandas().set_index("time") for f in files}


class Recorded(Mapping[str, Signal]):
    """Recorded signals in memory, as ``Result``: ``tables`` by row period (s)."""

    def __init__(self, tables: Mapping[Fraction, Mapping[str, Signal]]) -> None:
        self._tables = tables
        self._signals: dict[str, Signal] = {}
        for period in sorted(tables):
            self._signals = {**tables[period], **self._signals}

    def at(self, period: Fraction) -> "Recorded":
        """Return what was recorded with that row period (s) alone."""
        return Recorded({p: of for p, of in self._tables.items() if p == period})

    def __getitem__(self, name: str) -> Signal:
        return self._signals[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._signals)

    def __len__(self) -> int:
        return len(self._signals)


def _numbers(column: Any) -> NDArray[np.float64]:
    """Return a chunked Arrow column (its ``to_numpy`` imports pandas)."""
    chunks = [np.from_dlpack(chunk) for chunk in column.chunks]
    return np.concatenate(chunks) if chunks else np.empty(0)


def reached(folder: Path) -> float | None:
    """Return the time (s) of the last row a run has written; None without rows."""
    ends = [_last_time(file) for file in _files(folder / "result")]
    return max((t for t in ends if t is not None), default=None)


def _columns(folder: Path, only: Fraction | None = None) -> dict[str, Path]:
    """Return which file holds each recorded variable, its shortest period first."""
    tables = folder / "result"
    if not tables.is_dir():
        raise FmuError(f"{folder}: holds no run: there is no folder result in it")
    columns: dict[str, Path] = {}
    for file in sorted(_files(tables), key=_period):
        if only not in (None, _period(file)):
            continue
        for name in _schema(file).names:
            if name != "time":
                columns.setdefault(name, file)
    return columns


def _period(file: Path) -> Fraction:
    """Return the period that ``every_<n>_<d>_s`` says."""
    return Fraction(*map(int, file.stem.split("_")[1:3]))


def _files(tables: Path) -> list[Path]:
    """Return the files of all tables; Parquet before Arrow, none that is empty."""
    arrows = [f for f in tables.glob("*.arrows") if _begun(f)]
    return sorted({*map(_now, arrows), *tables.glob("*.parquet")})


def _begun(file: Path) -> bool:
    with suppress(FileNotFoundError):  # the run has just ended
        return file.stat().st_size > 0
    return False


def _now(file: Path) -> Path:
    """Return the file that a table is in now; a run may have ended meanwhile."""
    parquet = file.with_suffix(".parquet")
    return parquet if parquet.exists() else file


def _schema(file: Path) -> Any:
    import pyarrow.parquet

    if file.suffix == ".parquet":
        return pyarrow.parquet.read_schema(file)
    with pyarrow.ipc.open_stream(file) as reader:
        return reader.schema


def _read(file: Path, columns: list[str] | None = None) -> Any:
    import pyarrow as pa
    import pyarrow.parquet

    file = _now(file)
    if file.suffix == ".parquet":
        with pyarrow.parquet.ParquetFile(file) as parquet:  # read_table imports pandas
            return parquet.read(columns=columns)
    with pyarrow.ipc.open_stream(file) as reader:
        table = pa.Table.from_batches(_batches(reader), reader.schema)
    return table.select(columns) if columns else table


def _batches(reader: Any) -> Iterator[Any]:
    """Yield the batches of a stream; the last one of a killed run may be cut."""
    import pyarrow as pa

    with suppress(pa.ArrowInvalid, OSError):
        yield from reader


def _last_time(file: Path) -> float | None:
    import pyarrow as pa
    import pyarrow.parquet

    if file.suffix == ".parquet":
        with pyarrow.parquet.ParquetFile(file) as parquet:
            groups = parquet.num_row_groups
            if not groups:
                return None
            times = parquet.read_row_group(groups - 1, columns=["time"])["time"]
            return float(times[-1].as_py()) if len(times) else None
    last = None
    with pa.memory_map(str(file)) as mapped, pa.ipc.open_stream(mapped) as reader:
        for batch in _batches(reader):
            last = batch
        return None if last is None else float(last["time"][-1].as_py())
