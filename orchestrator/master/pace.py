"""A run held to the clock: simulated time goes ``pace`` times as fast as real time.

Instants are carried out in blocks of ``BLOCK`` s of the clock, or one by one where they
are farther apart; after a block the run sleeps until the clock has come to its last
instant.  A block that is done later than that is an overrun: nothing is left out, the
next ones catch up.  Values and bits do not depend on it.
"""

from dataclasses import dataclass, field
from math import ceil
from time import perf_counter, sleep

from orchestrator.errors import SimulationError
from orchestrator.master.timetable import Timetable
from orchestrator.result import Paced

BLOCK = 1e-3  # s of the clock between two looks at it
FACTORS = (1e-3, 1e3)  # how much slower and faster than the clock a run may be


@dataclass
class Pacer:
    """Holds an executor to the clock; ``pace`` is simulated time over real time."""

    pace: float
    timetable: Timetable
    begun: float = field(default_factory=perf_counter)
    late: list[float] = field(default_factory=list)
    overruns: int = 0

    def __post_init__(self) -> None:
        low, high = FACTORS
        if not low <= self.pace <= high:
            raise SimulationError(
                f"pace {self.pace:g}: give a factor from {low:g} to {high:g}; 1 is as "
                f"fast as the clock"
            )
        tick = float(self.timetable.schedule.tick)
        self._ticks = max(1, ceil(BLOCK * self.pace / tick - 1e-9))

    def first(self) -> int:
        """Start the clock; return the instant up to which the first block goes."""
        self.begun = perf_counter()
        return 0

    def reached(self, k: int) -> int:
        """Wait until the clock comes to instant k; return the end of the next block."""
        due = self.begun + self.timetable.schedule.seconds(k) / self.pace
        left = due - perf_counter()
        if left >= 0:
            sleep(left)
        else:
            self.overruns += 1
        self.late.append(perf_counter() - due)
        return k + self._ticks

    def told(self) -> Paced:
        """Return how well the clock was kept."""
        late = sorted(self.late) or [0.0]
        rms = (sum(t * t for t in late) / len(late)) ** 0.5
        return Paced(self.pace, len(self.late), self.overruns, late[-1], rms)
