"""A checkpoint as a file: what a run holds behind an instant.

The SHA-256 of what follows, and a NumPy archive: ``about`` as JSON, the vector, what
the executor remembers, the serialised state of every FMU.  It appears by a rename.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
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
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.master.layout import Wiring
from orchestrator.master.remembered import Remembered
from orchestrator.quantities.quantity import time_text

NAME = "checkpoint"
KEPT = "checkpoints"
FORMAT = 2


@dataclass(frozen=True)
class Saved:
    """What stands in a checkpoint: ``count`` instants were done, in ``wall_s`` s.

    ``rows`` are the bytes that each stream of rows had; ``about`` says besides which
    system it is of (``described``).
    """

    count: int
    instant: int
    wall_s: float
    rows: Mapping[str, int]
    vector: NDArray[np.float64]
    remembered: Remembered
    states: Mapping[str, bytes]
    about: Mapping[str, Any]

    @property
    def time(self) -> Fraction:
        """The time (s) of its instant."""
        return self.instant * Fraction(self.about["tick"])


def kept_name(time: Fraction) -> str:
    """Return the name of the checkpoint that is kept of a time (s)."""
    return f"at_{time.numerator}_{time.denominator}_s"


def kept_times(folder: Path) -> dict[Fraction, Path]:
    """Return the checkpoints that the folder of a run keeps, by their time (s)."""
    found = {}
    for file in (folder / KEPT).glob("at_*_s"):
        _, numerator, denominator, _ = file.name.split("_")
        found[Fraction(int(numerator), int(denominator))] = file
    if (folder / NAME).is_file():
        found.setdefault(read(folder / NAME).time, folder / NAME)
    return dict(sorted(found.items()))


def write(file: Path, saved: Saved) -> None:
    """Write a checkpoint, complete or not at all.

    Raises:
        OSError: the disk is full or gone.
    """
    about = dict(saved.about)
    for name in ("count", "instant", "wall_s", "rows"):
        about[name] = getattr(saved, name)
    arrays = {
        "about": np.frombuffer(json.dumps(about).encode(), np.uint8),
        "vector": saved.vector,
        "faults": saved.remembered.faults,
        **{f"line {name}": line for name, line in saved.remembered.lines.items()},
        **{f"state {n}": np.frombuffer(s, np.uint8) for n, s in saved.states.items()},
    }
    content = BytesIO()
    np.savez(content, **arrays)  # type: ignore[arg-type]
    data = content.getvalue()
    partial = file.with_suffix(".partial")
    partial.write_bytes(sha256(data).digest() + data)
    on_disk(partial)
    partial.replace(file)
    on_disk(file.parent)


def read(file: Path) -> Saved:
    """Return what stands in a checkpoint.

    Raises:
        SimulationError: it is gone, damaged, or of another edition.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise SimulationError(f"{file}: cannot be read ({error})") from None
    if data[:32] != sha256(data[32:]).digest():
        raise SimulationError(
            f"{file}: is damaged; delete it, and the run begins anew without it"
        )
    with np.load(BytesIO(data[32:]), allow_pickle=False) as arrays:
        about = json.loads(arrays["about"].tobytes())
        if about.get("format") != FORMAT:
            raise SimulationError(
                f"{file}: was written by another edition of feeddrive; delete it, and "
                f"the run begins anew"
            )
        return Saved(
            int(about["count"]),
            int(about["instant"]),
            float(about["wall_s"]),
            about["rows"],
            arrays["vector"],
            Remembered(dict(_named(arrays, "line")), arrays["faults"]),
            {name: a.tobytes() for name, a in _named(arrays, "state")},
            about,
        )


def _named(arrays: Any, kind: str) -> Iterator[tuple[str, NDArray[Any]]]:
    for key in arrays.files:
        if key.startswith(f"{kind} "):
            yield key.removeprefix(f"{kind} "), arrays[key]


def described(wiring: Wiring) -> dict[str, Any]:
    """Return, as JSON has it, what a checkpoint fits: of every component its FMU's
    digest, times, places and copies; beside them what may differ in a warm start.
    """
    return {
        "components": {name: _component(wiring, name) for name in wiring.parts},
        "start": {
            name: {v.name: as_text(v, values) for v, values in part.start}
            for name, part in wiring.parts.items()
        },
        "faults": [
            [f.place, [[str(value) for value in vars(x).values()] for x in f.faults]]
            for f in wiring.faulty
        ],
    }


def as_text(variable: FmuVariable, values: Sequence[Held]) -> str:
    """Return the values of a variable as a text, the same for the same values."""
    real = variable.sort == "real"
    return repr([float(v) if real and isinstance(v, int) else v for v in values])


def _component(wiring: Wiring, name: str) -> dict[str, Any]:
    part = wiring.parts[name]
    component = part.component
    return {
        "fmu": digest(part.fmu.path),
        "step": time_text(component.period),
        "offset": time_text(component.offset),
        "latency": component.latency,
        "kind": part.kind,
        "split": part.splits,
        "interface": "CS" if part.fmu.co_simulation else "ME",
        "connections": [str(copy) for copy in part.copies],
        "inputs": [v.name for v in part.inputs],
        "read": [v.name for v in part.read],
        "places": [part.first_input, part.raw, part.published, part.delayed],
    }
