"""Rows on their way to disk: Arrow streams while running, Parquet at the end.

One file per row period.  Rows are collected in chunks, column after column, by
either executor, and flushed when a chunk is full or ``flush`` is called, so that
what a killed run had flushed stays readable; ``close`` turns the streams into
Parquet.
"""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.master.layout import Column
from orchestrator.master.timetable import table_name

# rows collected at most; a cache line beyond a power of two, lest all columns share
# the same few lines of the cache
CHUNK = 4096 + 8
GROUP = 1 << 17  # rows of a Parquet row group, about
END = b"\xff\xff\xff\xff\0\0\0\0"  # of a stream, as Arrow's IPC format has it
# signals hardly repeat: a dictionary takes nine times as long and twice the space
PARQUET: dict[str, Any] = {
    "use_dictionary": False,
    "column_encoding": "BYTE_STREAM_SPLIT",
    "compression": "zstd",
}


def refuse_no_room(
    folder: Path, tables: Mapping[Fraction, tuple[Column, ...]], stop: Fraction
) -> None:
    """Refuse a run whose rows would not fit on the disk, before it begins.

    Raises:
        SimulationError: there is less space than the rows need.
    """
    rows = {period: stop // period + 1 for period in tables}
    needed = sum(8 * n * (1 + len(tables[period])) for period, n in rows.items())
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise SimulationError(
            f"{folder}: {sum(rows.values()):,} rows need about {needed / 1e9:.3g} GB, "
            f"{free / 1e9:.3g} GB are free; record less, give [record] a longer "
            f"period, or lower stop"
        )


class Recorder:
    """All tables of one run by their name.

    ``kept`` says how many bytes of each stream are kept, if it is to be continued.
    """

    def __init__(
        self,
        folder: Path,
        tables: Mapping[Fraction, tuple[Column, ...]],
        vector: NDArray[np.float64],
        kept: Mapping[str, int] | None = None,
    ) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        files = {p: folder / f"{_stem(p)}.arrows" for p in tables}
        for old in folder.glob("every_*_s.*"):
            if kept is None or old not in files.values():
                old.unlink()
        self.tables = {
            table_name(period): Table(
                files[period],
                columns,
                vector,
                None if kept is None else kept[files[period].name],
            )
            for period, columns in tables.items()
        }

    def flush(self) -> None:
        """Write every row recorded so far."""
        for table in self.tables.values():
            table.flush()

    def on_disk(self) -> dict[str, int]:
        """Write every row recorded so far, wait until all are on the disk, and return
        how many bytes each stream has.
        """
        return {table.path.name: table.on_disk() for table in self.tables.values()}

    def close(
        self, *, complete: bool, converted: Callable[[], None] = lambda: None
    ) -> None:
        """End the streams; of a complete run make Parquet tables of them.

        ``converted`` is called when all tables are there, before streams are deleted.
        Of a run that failed that failure is what counts: nothing is raised then.
        """
        for table in self.tables.values():
            with nullcontext() if complete else suppress(SimulationError):
                table.close()
        for table in self.tables.values() if complete else ():
            try:
                _to_parquet(table.path)
            except OSError as error:
                raise _full(table.path.with_suffix(".parquet"), error) from None
        if complete:
            converted()
            for table in self.tables.values():
                table.path.unlink()


def _about(column: Column) -> dict[str, str]:
    """Return a column's metadata: its unit, and the instants it is published at."""
    published = column.published
    about = column.unit.metadata()
    return about | ({"published": str(published)} if published else {})


class Table:
    """Rows of one period: ``time`` (s, CHUNK) and ``values`` (columns, CHUNK).

    ``index`` says where in the vector each column comes from; ``count[0]`` rows
    are waiting to be flushed.
    """

    def __init__(
        self,
        path: Path,
        columns: tuple[Column, ...],
        vector: NDArray[np.float64],
        kept: int | None = None,
    ) -> None:
        import pyarrow as pa

        self.path = path
        fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
        for c in columns:
            kind = pa.float64() if c.affine.converts else getattr(pa, c.dtype)()
            fields.append(pa.field(c.name, kind, metadata=_about(c)))
        self._pa, self._schema = pa, pa.schema(fields)
        self._dtypes = [np.dtype(c.dtype) for c in columns]
        if kept is None:
            self._file = path.open("wb")
            self._file.write(self._schema.serialize())
        else:
            self._file = _continued(path, self._schema, kept)
        self.index = np.array([c.index for c in columns], dtype=np.intp)
        self._affine = {
            i: (c.affine.gain, c.affine.offset)
            for i, c in enumerate(columns)
            if c.affine.converts
        }
        self._vector = vector
        self.time = np.empty(CHUNK)
        self.values = np.empty((len(columns), CHUNK))
        self.count = np.zeros(1, dtype=np.int64)

    def row(self, t: float) -> None:
        """Append the values now in the vector."""
        n = int(self.count[0])
        self.time[n] = t
        self.values[:, n] = self._vector[self.index]
        self.count[0] = n + 1
        if n + 1 == CHUNK:
            self.flush()

    def flush(self) -> None:
        """Write the rows that are waiting.

        Raises:
            SimulationError: the disk is full or gone.
        """
        n = int(self.count[0])
        if not n:
            return
        columns = [
            self._pa.Array.from_buffers(kind, n, [None, self._pa.py_buffer(values)])
            for kind, values in zip(self._schema.types, self._converted(n), strict=True)
        ]  # on the same memory (pa.array imports pandas)
        self.count[0] = 0
        try:
            batch = self._pa.record_batch(columns, schema=self._schema)
            self._file.write(batch.serialize())
            self._file.flush()
        except OSError as error:
            raise _full(self.path, error) from None

    def on_disk(self) -> int:
        """Wait until all rows are on the disk; return how many bytes there are.

        Raises:
            SimulationError: the disk is full or gone.
        """
        self.flush()
        try:
            self._file.flush()
            os.fsync(self._file.fileno())
            return self._file.tell()
        except OSError as error:
            raise _full(self.path, error) from None

    def _converted(self, n: int) -> Iterator[NDArray[Any]]:
        yield self.time[:n]
        for i, places in enumerate(self.values[:, :n]):
            values = places.view(self._dtypes[i])
            if i in self._affine:
                gain, offset = self._affine[i]
                yield gain * values.astype(np.float64) + offset
            else:
                yield values

    def close(self) -> None:
        """Flush and end the stream.

        Raises:
            SimulationError: the disk is full or gone.
        """
        try:
            self.flush()
            self._file.write(END)
            self._file.flush()
        except OSError as error:
            raise _full(self.path, error) from None
        finally:
            with suppress(OSError):  # which tries to write once more
                self._file.close()


def _continued(path: Path, schema: Any, kept: int) -> Any:
    """Open a stream of this schema behind its first ``kept`` bytes; cut the rest.

    Raises:
        SimulationError: it is shorter, or has other columns.
    """
    import pyarrow as pa

    try:
        with pa.ipc.open_stream(path) as reader:
            same = reader.schema.equals(schema, check_metadata=True)
        if path.stat().st_size < kept:
            raise SimulationError(f"{path}: is shorter than it was; run again")
        if not same:
            raise SimulationError(f"{path}: has other columns than the run; run again")
        file = path.open("r+b")
        file.truncate(kept)
        file.seek(kept)
    except (OSError, pa.ArrowInvalid) as error:
        raise SimulationError(f"{path}: cannot be continued ({error})") from None
    return file


def _full(path: Path, error: OSError) -> SimulationError:
    return SimulationError(
        f"{path}: rows cannot be written ({error}); free some space or record less; "
        f"the rows before stay readable"
    )


def _stem(period: Fraction) -> str:
    return f"every_{period.numerator}_{period.denominator}_s"


def _to_parquet(path: Path) -> None:
    """Make a Parquet file of an Arrow stream, some batches at a time."""
    import pyarrow as pa
    import pyarrow.parquet

    target: Any = path.with_suffix(".partial")
    with (
        pa.OSFile(str(path)) as file,  # a path would be mapped into memory whole
        pa.ipc.open_stream(file) as stream,
        pyarrow.parquet.ParquetWriter(target, stream.schema, **PARQUET) as writer,
    ):
        waiting, rows = [], 0
        for batch in stream:
            waiting.append(batch)
            rows += batch.num_rows
            if rows >= GROUP:
                writer.write_table(pa.Table.from_batches(waiting))
                waiting, rows = [], 0
        if waiting:
            writer.write_table(pa.Table.from_batches(waiting))
    target.replace(path.with_suffix(".parquet"))
