"""Rows on their way to disk: Arrow streams while running, Parquet at the end.

One file per row period.  Rows are collected in chunks and flushed when a chunk
is full or ``flush`` is called, so that what a killed run had flushed stays
readable; ``close`` turns the streams into Parquet.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.timetable import table_name
from orchestrator.wiring import Column

CHUNK = 4096


class Recorder:
    """All tables of one run; ``rows`` maps a table's name to its row function."""

    def __init__(
        self,
        folder: Path,
        tables: Mapping[Fraction, tuple[Column, ...]],
        vector: NDArray[np.float64],
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        for old in (*folder.glob("*.arrows"), *folder.glob("*.parquet")):
            old.unlink()
        self._tables = [
            _Table(folder / f"{_stem(period)}.arrows", columns, vector)
            for period, columns in tables.items()
        ]
        names = [table_name(period) for period in tables]
        self.rows: dict[str, Callable[[float], None]] = {
            name: table.row for name, table in zip(names, self._tables, strict=True)
        }

    def flush(self) -> None:
        """Write every row recorded so far."""
        for table in self._tables:
            table.flush()

    def close(self, *, complete: bool) -> None:
        """End the streams; of a complete run make Parquet tables of them."""
        for table in self._tables:
            table.close()
            if complete:
                _to_parquet(table.path)


class _Table:
    def __init__(
        self, path: Path, columns: tuple[Column, ...], vector: NDArray[np.float64]
    ) -> None:
        import pyarrow as pa

        self.path = path
        fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
        fields += [
            pa.field(c.name, pa.float64(), metadata={"unit": c.unit}) for c in columns
        ]
        self._pa, self._schema = pa, pa.schema(fields)
        self._file = path.open("wb")
        self._stream = pa.ipc.new_stream(self._file, self._schema)
        self._index = np.array([c.index for c in columns], dtype=np.intp)
        self._affine = [
            (i, c.affine.gain, c.affine.offset)
            for i, c in enumerate(columns)
            if (c.affine.gain, c.affine.offset) != (1.0, 0.0)
        ]
        self._vector = vector
        self._time = np.empty(CHUNK)
        self._values = np.empty((CHUNK, len(columns)))
        self._count = 0

    def row(self, t: float) -> None:
        n = self._count
        self._time[n] = t
        self._vector.take(self._index, out=self._values[n])
        self._count = n + 1
        if self._count == CHUNK:
            self.flush()

    def flush(self) -> None:
        if not self._count:
            return
        values = self._values[: self._count].T.copy()
        for i, gain, offset in self._affine:
            values[i] = gain * values[i] + offset
        arrays = [self._time[: self._count].copy(), *values]
        columns = [self._pa.array(array) for array in arrays]
        self._count = 0
        try:
            batch = self._pa.record_batch(columns, schema=self._schema)
            self._stream.write_batch(batch)
            self._file.flush()
        except OSError as error:
            raise SimulationError(
                f"{self.path}: rows cannot be written ({error}); free some space or "
                f"record less; the rows before stay readable"
            ) from None

    def close(self) -> None:
        try:
            self.flush()
            self._stream.close()
        finally:
            self._file.close()


def _stem(period: Fraction) -> str:
    return f"every_{period.numerator}_{period.denominator}_s"


def _to_parquet(path: Path) -> None:
    """Turn an Arrow stream into a Parquet file, batch by batch, and remove it."""
    import pyarrow as pa
    import pyarrow.parquet

    target: Any = path.with_suffix(".parquet")
    with (
        pa.ipc.open_stream(path) as stream,
        pyarrow.parquet.ParquetWriter(target, stream.schema) as writer,
    ):
        for batch in stream:
            writer.write_batch(batch)
    path.unlink()
