"""The state of a run at an instant, on the disk: from there it goes on, bit for bit.

``checkpoint`` in the folder of a run is the SHA-256 of what follows and a NumPy
archive: what the vector, the executor and all FMUs hold behind an instant, and how
many bytes of each stream of rows were written then.  Rows are on the disk before it,
and it appears by a rename; of a run that is killed the latest one holds, and goes
when the run has its tables.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.cache import digest, on_disk
from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.instances.saving import restore, save
from orchestrator.master.groups import only_python
from orchestrator.master.recorder import Recorder
from orchestrator.master.remembered import Remembered
from orchestrator.master.timetable import Timetable

NAME = "checkpoint"
FORMAT = 1


@dataclass(frozen=True)
class Checkpoints:
    """``every`` so many seconds of simulated time; ``resumed``: go on from the latest
    one, from the beginning if there is none.
    """

    every: Fraction
    resumed: bool = False


@dataclass(frozen=True)
class Saved:
    """What stands in a checkpoint: ``count`` instants were done, in ``wall_s`` s."""

    count: int
    instant: int
    wall_s: float
    rows: Mapping[str, int]
    vector: NDArray[np.float64]
    remembered: Remembered
    states: Mapping[str, bytes]


def refuse_unsaved(timetable: Timetable, executor: str | None) -> None:
    """Refuse checkpoints of a system of which some state cannot be saved.

    Raises:
        SimulationError: it names all such FMUs.
    """
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
        self._every = checkpoints.every / timetable.schedule.tick
        self._instances, self._vector = instances, vector
        self._about = {"format": FORMAT, "system": _fingerprint(timetable)}
        self.saved: Saved | None = None
        if checkpoints.resumed and self.file.exists():
            self.saved = self._read()
            vector[:] = self.saved.vector
            for name, state in self.saved.states.items():
                restore(instances[name], state)

    def begin(self, engine: Any, rows: Recorder) -> float:
        """Let an engine go on from the latest checkpoint, or write one before the first
        instant; return what the run took until then (s).
        """
        saved = self.saved
        if saved is None:
            for path in self.file.parent.rglob("*"):  # lock, FMUs and all
                on_disk(path)
            self.write(0, engine, 0.0, rows)
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
        states = {name: save(one) for name, one in self._instances.items()}
        remembered: Remembered = engine.remembered()
        about = self._about | {
            "count": engine.count,
            "instant": instant,
            "wall_s": wall_s,
            "rows": rows.on_disk(),
        }
        arrays = {
            "about": np.frombuffer(json.dumps(about).encode(), np.uint8),
            "vector": self._vector,
            "faults": remembered.faults,
            **{f"line {name}": line for name, line in remembered.lines.items()},
            **{f"state {n}": np.frombuffer(s, np.uint8) for n, s in states.items()},
        }
        content = BytesIO()
        np.savez(content, **arrays)  # type: ignore[arg-type]
        data = content.getvalue()
        partial = self.file.with_suffix(".partial")
        try:
            partial.write_bytes(sha256(data).digest() + data)
            on_disk(partial)
            partial.replace(self.file)
            on_disk(self.file.parent)
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
        try:
            data = self.file.read_bytes()
        except OSError as error:
            raise SimulationError(f"{self.file}: cannot be read ({error})") from None
        if data[:32] != sha256(data[32:]).digest():
            raise SimulationError(
                f"{self.file}: is damaged; delete it, and the run begins anew"
            )
        with np.load(BytesIO(data[32:]), allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if {key: about.get(key) for key in self._about} != self._about:
                raise SimulationError(
                    f"{self.file}: is of another system: FMUs, connections, rates or "
                    f"values are not those of the run; delete it to begin anew"
                )
            return Saved(
                int(about["count"]),
                int(about["instant"]),
                float(about["wall_s"]),
                about["rows"],
                arrays["vector"],
                Remembered(dict(_named(arrays, "line")), arrays["faults"]),
                {name: a.tobytes() for name, a in _named(arrays, "state")},
            )


def _named(arrays: Any, kind: str) -> Iterator[tuple[str, NDArray[Any]]]:
    for key in arrays.files:
        if key.startswith(f"{kind} "):
            yield key.removeprefix(f"{kind} "), arrays[key]


def _fingerprint(timetable: Timetable) -> str:
    """Return a digest of what a checkpoint fits: FMU files, layout, rates, values."""
    wiring, told = timetable.wiring, sha256()
    for name, part in wiring.parts.items():
        component = part.component
        inputs, read = ([v.name for v in of] for of in (part.inputs, part.read))
        times = component.period, component.offset, component.latency, component.split
        places = part.first_input, part.raw, part.published, part.delayed
        told.update(
            repr(
                (name, digest(part.fmu.path), inputs, read, times, places, part.copies)
            ).encode()
        )
        told.update(repr([(v.name, values) for v, values in part.start]).encode())
    schedule = timetable.schedule
    rows = {p: [(c.name, c.index) for c in table] for p, table in wiring.tables.items()}
    told.update(repr((wiring.faulty, schedule, rows)).encode())
    return told.hexdigest()
