"""Where the time of a run went: per component, in the master, on disk.

An executor that profiles reads the clock after every operation and adds the
time since the previous reading to the FMU (step, get, set) or to the master
(exchange, latency lines, rows); the cost of the readings is taken off.
"""

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Spent:
    """Time inside the FMU of one component (s) and how often it was stepped."""

    steps: int
    seconds: float


@dataclass(frozen=True)
class Profile:
    """``components`` and ``master_s`` sum up what the executor did; ``rest_s`` is
    everything else in the wall time: writing rows, progress, reading the clock.

    ``peak_bytes`` is the largest resident memory so far; 0 where unknown.
    """

    components: Mapping[str, Spent]
    master_s: float
    rest_s: float
    peak_bytes: int

    @classmethod
    def of(
        cls, components: Mapping[str, Spent], master_s: float, wall_s: float
    ) -> "Profile":
        """Return the profile of a run that took ``wall_s``."""
        busy = master_s + sum(spent.seconds for spent in components.values())
        return cls(components, master_s, wall_s - busy, peak_memory())

    def as_json(self) -> dict[str, Any]:
        """Return what ``run --profile --json`` prints of it."""
        return {
            "components": {
                name: vars(spent) for name, spent in self.components.items()
            },
            "master_s": self.master_s,
            "rest_s": self.rest_s,
            "peak_bytes": self.peak_bytes,
        }


def peak_memory() -> int:
    """Return the largest resident memory of this process in bytes, 0 if unknown."""
    if sys.platform == "win32":
        return 0
    import resource

    status = Path("/proc/self/status")  # getrusage counts what ran before exec too
    if status.is_file():
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        return 1024 * int(found[1]) if found else 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
