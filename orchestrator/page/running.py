"""A kept run that the page watches: its progress, its curves so far, its abort."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from orchestrator.analysis.variations import Setting
from orchestrator.errors import FeedDriveError, Interrupted
from orchestrator.master.timetable import Timetable
from orchestrator.outcome import Run
from orchestrator.page.kept import Passing
from orchestrator.quantities.quantity import time_text
from orchestrator.result import Recorded, Signal
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import execute, naming, run_earlier

Told = Callable[[float, float, Passing | None], None]  # t, stop (s), rows so far


def sets_of(settings: Mapping[str, Setting]) -> tuple[str, ...]:
    """Return settings as texts for ``--set``."""
    return tuple(f"{key}={value}" for key, value in settings.items())


@dataclass
class Running:
    """A run that goes on in a thread of its own until it ends or is aborted."""

    file: Path
    settings: Mapping[str, Setting]
    pace: float | None = None
    aborted: Event = field(default_factory=Event)

    def abort(self) -> None:
        """End it at its next look; what was recorded stays."""
        self.aborted.set()

    def run(self, told: Told) -> Run:
        """Run it into a folder of ``runs/``; tell how far it is now and then.

        Raises:
            Interrupted: it was aborted; what was recorded stays.
            FeedDriveError: it cannot be run, or the run failed.
        """
        scenario = load_scenario(self.file, sets_of(self.settings))
        with naming(scenario):
            composition = compose(scenario, run_earlier)
            self._go_on(Fraction(0))
            so_far: list[SoFar] = []
            stop = float(composition.system.stop)

            def progress(t: Fraction) -> None:
                rows = so_far[0].rows() if so_far and t < stop else None
                told(float(t), stop, rows)
                self._go_on(t)

            def begun(folder: Path, timetable: Timetable) -> None:
                so_far.append(SoFar(composition, folder, timetable))

            return execute(
                composition, progress=progress, watched=begun, pace=self.pace
            )

    def _go_on(self, t: Fraction) -> None:
        if self.aborted.is_set():
            raise Interrupted(f"aborted at t = {time_text(t)} s")


class SoFar:
    """The rows of a run under way, read from its streams as they are flushed."""

    def __init__(
        self, composition: Composition, folder: Path, timetable: Timetable
    ) -> None:
        self._composition, self._folder = composition, folder
        self._columns = timetable.wiring.tables
        self._places: dict[Path, int] = {}
        self._batches: dict[Fraction, list[Any]] = {p: [] for p in self._columns}

    def rows(self) -> Passing | None:
        """Return what was recorded so far, None where there is nothing to draw yet."""
        tables = {}
        for period, columns in self._columns.items():
            self._read(period)
            batches = self._batches[period]
            if not batches:
                return None
            time = _joined(batches, "time")
            signals = (
                Signal(c.name, time, _joined(batches, c.name), c.unit, c.published)
                for c in columns
            )
            tables[period] = {signal.name: signal for signal in signals}
        with suppress(FeedDriveError):  # too few rows for what a metric compares
            return Passing(self._composition, Recorded(tables), unfinished=True)
        return None

    def _read(self, period: Fraction) -> None:
        import pyarrow as pa

        name = f"every_{period.numerator}_{period.denominator}_s.arrows"
        path = self._folder / "result" / name
        if not path.is_file():
            return
        with pa.OSFile(str(path)) as file, suppress(EOFError, pa.ArrowInvalid):
            schema = pa.ipc.read_schema(pa.ipc.read_message(file))
            file.seek(self._places.get(path, file.tell()))
            while True:
                self._places[path] = file.tell()
                batch = pa.ipc.read_record_batch(pa.ipc.read_message(file), schema)
                self._batches[period].append(batch)


def _joined(batches: list[Any], name: str) -> Any:
    return np.concatenate([np.from_dlpack(batch[name]) for batch in batches])
