"""A whole run in a process of its own, for FMUs that nothing keeps apart from it.

``isolation = "none"`` lets an FMU of others into the process that runs the system.
That is then a child of the command or test: what such an FMU does to it, an
``exit(0)`` included, ends the child alone.  Its parent names FMU and call; rows that
were written stay readable.
"""

import multiprocessing as mp
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from threading import Thread
from typing import Any

from fmus.trust import is_trusted
from orchestrator.errors import FeedDriveError, SimulationError
from orchestrator.folders.temporary import sweep
from orchestrator.instances.child import Child, how_ended
from orchestrator.instances.descendants import MARK, end_marked
from orchestrator.instances.doing import NOBODY, keep, noted
from orchestrator.instances.frames import encode
from orchestrator.master.timetable import Timetable
from orchestrator.result import End, Result, Timing
from orchestrator.system import System
from orchestrator.warned import collecting, warn

NOTES = ".doing"  # file in the folder of the run, while it goes on
LONG = 1e6  # s; such a run has no limit
CALLS = {0: "doStep", 1: "get", 4: "set"}  # operations of the kernel

_INSIDE: list[bool] = []


def let_in(timetable: Timetable) -> list[str]:
    """Return the FMUs of others that run in the process of the run, none inside it."""
    parts = timetable.wiring.parts.items()
    return [
        name
        for name, part in parts
        if part.component.isolation.process is False and not is_trusted(part.fmu.path)
    ] * (not _INSIDE)


def simulate_apart(
    simulate: Callable[..., Result],
    system: System,
    folder: Path,
    timetable: Timetable,
    progress: Callable[[Fraction], None] | None,
    executor: str | None,
) -> Result:
    """Call ``simulate`` in a child, which has no profile."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / NOTES
    child = Child(
        *(_serve, simulate, system, folder, executor),
        log=lambda _: None,
        ended=lambda: None,
    )
    code = None
    try:
        while True:
            kind, value = child.answer(LONG)
            if kind == "warned":
                warn(value)
            elif kind == "reached" and progress:
                progress(Fraction(value))
            elif kind == "error":
                raise value
            elif kind == "finished":
                code = child.join(LONG)
                timing, ended = value
                return Result(folder, Timing(*timing), End(*ended) if ended else None)
            elif kind == "ended":
                raise _died(child, file, timetable)
    finally:
        child.close()
        file.unlink(missing_ok=True)
        sweep()  # what it had unpacked
        if code:
            warn(f"the process of the run ended with {how_ended(code)} after its end")


def _died(child: Child, file: Path, timetable: Timetable) -> SimulationError:
    names = list(timetable.wiring.parts)
    how = "is damaged" if child.damaged else f"ended with {how_ended(child.join(5.0))}"
    where, call = "the run", "its beginning"
    with suppress(OSError):
        doing = noted(file)
        if 0 <= doing.part < len(names) and doing.code in CALLS:
            where, call = names[doing.part], CALLS[doing.code]
        elif doing.part == NOBODY:
            where, _, call = doing.text.decode("utf-8", "replace").partition("\n")
    if where in timetable.wiring.parts:
        where += f" ({timetable.wiring.parts[where].fmu.path.name})"
    return SimulationError(
        f"{where}: the process of the run {how} during {call}; isolation = "
        f'"none" lets this FMU into it: leave it out, and the FMU has its own'
    )


def _serve(
    pipe: Any,
    simulate: Callable[..., Result],
    system: System,
    folder: Path,
    executor: str | None,
) -> None:
    """Simulate, in the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)
    with suppress(OSError):
        sys.stdout.flush()
        os.dup2(2, 1)
    Thread(target=_end_with_parent, daemon=True).start()
    mp.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    _INSIDE.append(True)
    keep(folder / NOTES)

    def tell(kind: str, value: Any) -> None:
        with suppress(OSError):
            pipe.send_bytes(encode(kind, value))

    def reached(t: Fraction) -> None:
        tell("reached", f"{t.numerator}/{t.denominator}")

    with collecting() as warnings:
        try:
            result = simulate(system, folder, progress=reached, executor=executor)
            told: tuple[str, Any] = "finished", result
        except FeedDriveError as error:
            told = "error", error
    for text in warnings:
        tell("warned", text)
    tell(*told)
    sys.stderr.flush()
    os._exit(0)


def _end_with_parent() -> None:
    parent = mp.parent_process()
    assert parent is not None
    mp.connection.wait([parent.sentinel])
    if mark := os.environ.get(MARK):
        end_marked(mark)
    os._exit(1)
