"""Many runs of one system, one after the other, its FMUs kept loaded.

A member differs in the parameters and start values that are written.  After one that
fails all FMUs are opened anew.  Rows stay in memory.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FeedDriveError
from orchestrator.instances.ending import Ended
from orchestrator.instances.protocol import Instance
from orchestrator.master.executor import Executor
from orchestrator.master.groups import only_python
from orchestrator.master.initialise import initialise
from orchestrator.master.kernel import Kernel
from orchestrator.master.layout import Column
from orchestrator.master.loaded import Loaded
from orchestrator.master.member import Values, timetable_with
from orchestrator.master.recorder import CHUNK
from orchestrator.master.simulate import Choice
from orchestrator.master.timetable import Timetable, table_name
from orchestrator.result import End, Recorded, Signal


class Series:
    """Runs members of a timetable's system on FMUs that are ``loaded``."""

    def __init__(
        self,
        timetable: Timetable,
        signals: frozenset[str],
        loaded: Loaded,
        executor: Choice | None = None,
    ) -> None:
        self._timetable, self._signals = timetable, signals
        self._loaded, self._executor = loaded, executor

    def run(self, values: Values) -> tuple[Recorded, End | None]:
        """Run a member whose components have these values besides their own.

        Return its signals, and how an FMU ended it before its stop if one did.

        Raises:
            WiringError: a value names no variable, or does not fit it.
            SimulationError: the member failed; the next one is not touched by it.
        """
        timetable = timetable_with(self._timetable, values)
        wiring = timetable.wiring
        vector = np.zeros(wiring.size)
        kept = {
            table_name(period): Kept(columns, vector)
            for period, columns in wiring.tables.items()
        }
        ended = None
        try:
            instances = self._loaded.instances(timetable)
            initialise(wiring, instances, vector)
            try:
                for _ in self._engine(timetable, instances, vector, kept).run():
                    pass
            except Ended as end:
                ended = End(end.by, end.at, end.reason)
        except FeedDriveError:
            self._loaded.drop()  # a process may have ended: the next is opened anew
            raise
        tables = {
            period: dict(kept[table_name(period)].signals(self._signals))
            for period in wiring.tables
        }
        return Recorded(tables), ended

    def _engine(
        self,
        timetable: Timetable,
        instances: Mapping[str, Instance],
        vector: NDArray[np.float64],
        kept: Mapping[str, "Kept"],
    ) -> Any:
        tables: Any = kept
        if self._executor == "python" or only_python(timetable.wiring):
            rows = {name: table.row for name, table in kept.items()}
            return Executor(timetable, instances, vector, rows)
        return Kernel(timetable, instances, vector, tables)


class Kept:
    """Rows of one period in memory, filled by either executor as a ``Table`` is."""

    def __init__(
        self, columns: tuple[Column, ...], vector: NDArray[np.float64]
    ) -> None:
        self._columns, self._vector = columns, vector
        self.index = np.array([c.index for c in columns], dtype=np.intp)
        self.time = np.empty(CHUNK)
        self.values = np.empty((len(columns), CHUNK))
        self.count = np.zeros(1, dtype=np.int64)
        self._done: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []

    def row(self, t: float) -> None:
        """Append the values now in the vector."""
        n = int(self.count[0])
        self.time[n] = t
        self.values[:, n] = self._vector[self.index]
        self.count[0] = n + 1
        if n + 1 == CHUNK:
            self.flush()

    def flush(self) -> None:
        """Put the rows that are waiting aside."""
        n = int(self.count[0])
        self._done.append((self.time[:n].copy(), self.values[:, :n].copy()))
        self.count[0] = 0

    def signals(self, names: frozenset[str]) -> list[tuple[str, Signal]]:
        """Return what was recorded of some signals."""
        self.flush()
        time = np.concatenate([t for t, _ in self._done])
        whole = np.concatenate([v for _, v in self._done], axis=1)
        found = []
        for column, values in zip(self._columns, whole, strict=True):
            if column.name in names:
                numbers = values.view(np.dtype(column.dtype)).astype(np.float64)
                if column.affine.converts:
                    numbers = column.affine.gain * numbers + column.affine.offset
                signal = Signal(
                    column.name, time, numbers, column.unit, column.published
                )
                found.append((column.name, signal))
        return found
