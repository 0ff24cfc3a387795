"""How long an item waits for its child: computing counts, not the clock.

On a busy machine a child may wait long for a processor; that is not its fault.  As
long as one of its threads is ready to run, only what it computes counts; when all
of them sleep, the clock does, since the FMU then waits for something that may
never come.  A call of the FMU that does not return is a hang, which is its fault;
an item whose many calls take too long together could not be run.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

LOOK = 0.1  # s between two looks, at least
SILENT = 20.0  # s that one call of an FMU may take
STARTING = 120.0  # s (clock) that a process may take before it touches the FMU


@dataclass(frozen=True)
class Over:
    """Why it is enough: ``verdict`` is how the item ends."""

    verdict: str
    seconds: float
    calls: int = 0

    def text(self, trying: str) -> str:
        """Say it, with what was being tried."""
        if self.verdict == "hung":
            return f"no end within {self.seconds:g} s while {trying}"
        if self.calls:
            return (
                f"not done within {self.seconds:g} s of computing, in which the FMU "
                f"was called {self.calls} times; the last was while {trying}"
            )
        return f"no end within {self.seconds:g} s on the clock while {trying}"


class Patience:
    """Look at a child now and then, and say when it is enough."""

    def __init__(self, pid: int, seconds: float) -> None:
        self._pid, self._seconds = pid, seconds
        self._seen = monotonic()
        self._computed = 0.0
        self._waited = self._spent = self._silent = 0.0  # s
        self._beats = 0
        self._measured = True

    def over(self, beats: int, begun: bool) -> Over | None:
        """Return why it is enough, None if it is not.

        ``beats`` counts the calls of the FMU that returned; nothing of the FMU has
        been touched before the child has ``begun``.
        """
        if monotonic() - self._seen < LOOK:
            return None
        passed = self._passed()
        if not begun:
            self._waited += passed
            late = self._waited > STARTING
            return Over("could not be run", STARTING) if late else None
        self._silent = 0.0 if beats != self._beats else self._silent + passed
        self._spent += passed
        self._beats = beats
        if self._silent > min(SILENT, self._seconds):
            verdict = "hung" if self._measured else "could not be run"
            return Over(verdict, min(SILENT, self._seconds))
        if self._spent > self._seconds and self._silent == 0.0:
            return Over("could not be run", self._seconds, max(beats, 1))
        return None

    def _passed(self) -> float:
        """Return what has to be counted since the last look (s)."""
        now = monotonic()
        clock, self._seen = now - self._seen, now
        running, computed = self._threads()
        computing, self._computed = max(0.0, computed - self._computed), computed
        return computing if running else clock

    def _threads(self) -> tuple[bool, float]:
        """Tell whether a thread is ready to run, and what all have computed (s)."""
        running, ticks = False, 0
        try:
            for task in Path(f"/proc/{self._pid}/task").iterdir():
                fields = (task / "stat").read_text().rpartition(")")[2].split()
                running = running or fields[0] == "R"
                ticks += int(fields[11]) + int(fields[12])
        except OSError:  # another system, or the child has just ended
            self._measured = Path("/proc/self/task").is_dir()
            return False, self._computed
        return running, ticks / os.sysconf("SC_CLK_TCK")
