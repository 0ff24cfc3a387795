"""Many runs of one system, one after the other, its FMUs kept loaded.

A member differs in the parameters and start values that are written; each FMU is
instantiated again in the library and the process that it has.  One whose process
has ended is opened anew.  Rows stay in memory.
"""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.master.apart import let_in
from orchestrator.master.executor import Executor
from orchestrator.master.initialise import initialise
from orchestrator.master.kernel import Kernel
from orchestrator.master.layout import Column
from orchestrator.master.member import Values, timetable_with
from orchestrator.master.recorder import CHUNK
from orchestrator.master.simulate import Choice, open_instance
from orchestrator.master.timetable import Timetable, table_name
from orchestrator.result import Recorded, Signal


class Series:
    """Runs members of a timetable's system; a context manager."""

    def __init__(
        self,
        timetable: Timetable,
        signals: frozenset[str],
        executor: Choice | None = None,
    ) -> None:
        self._timetable, self._signals = timetable, signals
        self._executor = executor
        self._stack = ExitStack()
        self._instances: dict[str, Instance] | None = None

    def __enter__(self) -> "Series":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def run(self, values: Values) -> Recorded:
        """Run a member whose components have these values besides their own.

        Raises:
            WiringError: a value names no variable, or does not fit it.
            SimulationError: the member failed; the next one is not touched by it.
        """
        timetable = timetable_with(self._timetable, values)
        wiring = timetable.wiring
        if self._instances is None:
            self._open(timetable)
        assert self._instances is not None
        vector = np.zeros(wiring.size)
        kept = {
            table_name(period): Kept(columns, vector)
            for period, columns in wiring.tables.items()
        }
        try:
            initialise(wiring, self._instances, vector)
            engine = self._engine(timetable, vector, kept)
            for _ in engine.run():
                pass
        except SimulationError:
            self._stack.close()  # a process may have ended: the next is opened anew
            self._instances = None
            raise
        return Recorded(
            {
                period: dict(kept[table_name(period)].signals(self._signals))
                for period in wiring.tables
            }
        )

    def _open(self, timetable: Timetable) -> None:
        shared: dict[Path, Path] = {}
        strangers = let_in(timetable)  # a series has no child of its own for them
        self._instances = {
            name: open_instance(
                *(name, part.fmu, self._stack),
                replace(part.component.isolation, process=True)
                if name in strangers
                else part.component.isolation,
                shared,
            )
            for name, part in timetable.wiring.parts.items()
        }

    def _engine(
        self,
        timetable: Timetable,
        vector: NDArray[np.float64],
        kept: Mapping[str, "Kept"],
    ) -> Any:
        assert self._instances is not None
        tables: Any = kept
        if self._executor == "python":
            rows = {name: table.row for name, table in kept.items()}
            return Executor(timetable, self._instances, vector, rows)
        return Kernel(timetable, self._instances, vector, tables)


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
