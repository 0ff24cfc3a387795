"""The state of a run at an instant, on the disk: from there it goes on, bit for bit.

Rows are on the disk before a checkpoint (``saved``) is; of a run that is killed the
latest one holds, and goes when the run has its tables.  Those that are kept stay, for
runs that begin there (``warm``).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.cache import on_disk
from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.instances.saving import restore, save
from orchestrator.master.apart import let_in
from orchestrator.master.groups import only_python
from orchestrator.master.recorder import Recorder
from orchestrator.master.saved import (
    FORMAT,
    KEPT,
    NAME,
    Saved,
    described,
    kept_name,
    read,
    write,
)
from orchestrator.master.timetable import Timetable


@dataclass(frozen=True)
class Checkpoints:
    """``every`` so many seconds of simulated time; ``resumed``: go on from the latest
    one, from the beginning if there is none; ``kept``: every one stays.
    """

    every: Fraction
    resumed: bool = False
    kept: bool = False


def refuse_options(
    timetable: Timetable,
    executor: str | None,
    *,
    profile: bool = False,
    saves: bool = False,
    paced: bool = False,
) -> None:
    """Refuse what cannot be asked for together, or of this system, before it runs.

    ``saves``: with checkpoints, or from one; ``paced``: held to the clock.

    Raises:
        SimulationError: the message says what to leave out.
    """
    if saves:
        _refuse_unsaved(timetable, executor)
    if saves and paced:
        raise SimulationError("checkpoints: a run has either a pace or checkpoints")
    asked = {"profile": profile, "checkpoints": saves, "pace": paced}
    for what in (what for what, given in asked.items() if given):
        for name in let_in(timetable):
            raise SimulationError(
                f"{name}: a run that lets this FMU into its process has no {what}; "
                f'leave out isolation = "none"'
            )


def _refuse_unsaved(timetable: Timetable, executor: str | None) -> None:
    if executor == "fused":
        raise SimulationError(
            "checkpoints: executor fused keeps states where no FMU can save them; "
            "leave --executor out"
        )
    if why := only_python(timetable.wiring):
        raise SimulationError(
            f"checkpoints: {why}, and a run with that is not gone on with; run without "
            f"--checkpoint"
        )
    cannot = [
        f"{part.name} ({part.fmu.path.name}) {_why(part.fmu.co_simulation)}"
        for part in timetable.wiring.parts.values()
        if not part.fmu.saves_state
    ]
    if cannot:
        raise SimulationError(
            f"checkpoints: {'; '.join(cannot)}; run without --checkpoint"
        )


def _why(co_simulation: bool) -> str:
    if co_simulation:
        return "does not serialise its state (canSerializeFMUState)"
    return "is for model exchange, and its integrator's history cannot be saved"


class Keeper:
    """Writes the checkpoints of one run in its folder, every so many ticks."""

    def __init__(
        self,
        folder: Path,
        checkpoints: Checkpoints,
        timetable: Timetable,
        instances: Mapping[str, Instance],
        vector: NDArray[np.float64],
    ) -> None:
        self.file = folder / NAME
        self._schedule = timetable.schedule
        self._every = checkpoints.every / self._schedule.tick
        self._kept = folder / KEPT if checkpoints.kept else None
        self._instances, self._vector = instances, vector
        about = described(timetable.wiring)
        about |= {"format": FORMAT, "tick": str(self._schedule.tick)}
        self._about = about | {"system": _fingerprint(timetable, about)}
        self.saved: Saved | None = None
        if checkpoints.resumed and self.file.exists():
            self.saved = self._read()
            vector[:] = self.saved.vector
            for name, state in self.saved.states.items():
                restore(instances[name], state)

    def begin(self, engine: Any, rows: Recorder, instant: int = 0) -> float:
        """Let an engine go on from the latest checkpoint, or write one before the first
        instant, behind ``instant`` in a warm start; return what the run took until then
        (s).
        """
        saved = self.saved
        if saved is None:
            for path in self.file.parent.rglob("*"):  # lock, FMUs and all
                on_disk(path)
            self.write(instant, engine, 0.0, rows)
            return 0.0
        engine.count = saved.count
        engine.remember(saved.remembered)
        engine.until = self._next(saved.instant)
        return saved.wall_s

    def _next(self, instant: int) -> int:
        """Return the instant of the first checkpoint behind an instant."""
        return int((instant // self._every + 1) * self._every)

    def write(self, instant: int, engine: Any, wall_s: float, rows: Recorder) -> None:
        """Write a checkpoint behind an instant that was carried out, and set the next.

        Raises:
            SimulationError: an FMU refuses, or the disk is full or gone.
        """
        engine.until = self._next(instant)
        saved = Saved(
            engine.count,
            instant,
            wall_s,
            rows.on_disk(),
            self._vector,
            engine.remembered(),
            {name: save(one) for name, one in self._instances.items()},
            self._about,
        )
        try:
            if self._kept and 0 < instant < self._schedule.stop:
                self._kept.mkdir(exist_ok=True)
                write(self._kept / kept_name(saved.time), saved)
            write(self.file, saved)
            on_disk(rows.folder)
        except OSError as error:
            raise SimulationError(
                f"{self.file}: a checkpoint cannot be written ({error}); the one "
                f"before and all rows stay"
            ) from None

    def drop(self) -> None:
        """Delete the checkpoint of a run that needs none any more."""
        self.file.unlink(missing_ok=True)

    def _read(self) -> Saved:
        saved = read(self.file)
        if saved.about["system"] != self._about["system"]:
            raise SimulationError(
                f"{self.file}: is of another system: FMUs, connections, rates or "
                f"values are not those of the run; delete it to begin anew"
            )
        return saved


def _fingerprint(timetable: Timetable, about: Mapping[str, Any]) -> str:
    """Return a digest of what a checkpoint fits: FMU files, layout, rates, values."""
    wiring = timetable.wiring
    rows = {p: [(c.name, c.index) for c in table] for p, table in wiring.tables.items()}
    told = repr((about, wiring.faulty, timetable.schedule, rows))
    return sha256(told.encode()).hexdigest()
