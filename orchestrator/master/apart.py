"""A whole run in a process of its own, for FMUs that nothing keeps apart from it.

``isolation = "none"`` lets an FMU of others into the process that runs the system.
That is then a child of the command or test: what such an FMU does to it, an
``exit(0)`` included, ends the child alone.  Its parent names FMU and call; rows that
were written stay readable.
"""

import multiprocessing as mp
import os
import queue
import sys
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import Any

from fmus.trust import is_trusted
from orchestrator.errors import FeedDriveError, SimulationError
from orchestrator.folders.temporary import sweep
from orchestrator.instances.child import Child, how_ended
from orchestrator.instances.descendants import MARK, end_marked
from orchestrator.instances.doing import NOBODY, THE_RUN, keep, noted
from orchestrator.instances.frames import encode
from orchestrator.instances.guard import guards, stand_guard
from orchestrator.instances.spawn import stand_alone
from orchestrator.master.layout import Part
from orchestrator.master.timetable import Timetable
from orchestrator.quantities.quantity import exact
from orchestrator.result import End, Result, Timing
from orchestrator.system import System
from orchestrator.warned import collecting, warn

NOTES = ".doing"  # file in the folder of the run, while it goes on
POLL = 0.25  # s between two looks at what an FMU does
ENDING_WITHIN = 5.0  # s to free an FMU
CALLS = {0: "doStep", 1: "get", 4: "set"}  # operations of the kernel

_INSIDE: list[bool] = []


def let_in(timetable: Timetable) -> list[str]:
    """Return the FMUs of others that run in the process of the run, none inside it."""
    return [] if _INSIDE else _foreign(timetable.wiring.system)


def _foreign(system: System) -> list[str]:
    return [
        name
        for name, component in system.components.items()
        if component.isolation.process is False and not is_trusted(component.fmu)
    ]


def simulate_apart(
    simulate: Callable[..., Result],
    system: System,
    folder: Path,
    timetable: Timetable,
    progress: Callable[[Fraction], None] | None,
    executor: str | None,
) -> Result:
    """Call ``simulate`` in a child, which has no profile.

    Raises:
        SimulationError: the run failed, or an FMU took more than its
            ``answer_within`` for a call, or the whole child along.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / NOTES
    child = Child(
        *(_serve, simulate, system, folder, executor),
        log=lambda _: None,
        ended=lambda: None,
    )
    patience = _Patience(file, timetable)
    try:
        while True:
            try:
                kind, value = child.answer(POLL)
            except queue.Empty:
                if late := patience.lost():
                    raise late from None
                continue
            patience.renew()
            if kind == "warned":
                warn(value)
            elif kind == "reached" and progress:
                progress(exact(value))
            elif kind == "error":
                raise value
            elif kind == "finished":
                timing, ended = value
                _free(child, file, timetable)
                return Result(folder, Timing(*timing), End(*ended) if ended else None)
            elif kind == "ended":
                raise _died(child, file, timetable)
    except ValueError:  # a time that is none
        raise _died(child, file, timetable) from None
    finally:
        child.close()
        file.unlink(missing_ok=True)
        sweep()  # what it had unpacked


class _Patience:
    """Knows how long one call of an FMU has lasted, by what the child notes."""

    def __init__(self, file: Path, timetable: Timetable) -> None:
        self._file, self._timetable = file, timetable
        self._seen = b""
        self.renew()

    def renew(self) -> None:
        self._since = monotonic()

    def lost(self) -> SimulationError | None:
        """Return the error of an FMU that took longer than it may."""
        with suppress(OSError):
            if (seen := self._file.read_bytes()) != self._seen:
                self._seen = seen
                self.renew()
        name, call = _doing(self._file, self._timetable)
        part = self._timetable.wiring.parts.get(name)
        if part is None:
            return None
        within = max(part.component.isolation.answer_within, 2 * POLL)
        if monotonic() - self._since < within:
            return None
        return SimulationError(
            f"{name} ({part.fmu.path.name}): no answer within {within:g} s "
            f"(answer_within) in {call}; the process of the run is killed"
        )


def _free(child: Child, file: Path, timetable: Timetable) -> None:
    """Wait for a child whose rows are complete; warn if its FMUs do not survive."""
    limits = [p.component.isolation.answer_within for p in _parts(timetable)]
    within = min(ENDING_WITHIN, *limits)
    code = child.join(within * len(limits))
    kind = "warned"
    with suppress(queue.Empty):
        while kind == "warned":
            kind, value = child.answer(0.0 if code is None else POLL)
            if kind == "warned":
                warn(value)
    if code == 0:
        return
    name, call = _doing(file, timetable)
    how = f"ended with {how_ended(code)}"
    if code is None:
        how = "did not end and is killed"
    warn(f"{name}: the process of the run {how} in {call}; the rows are complete")


def _parts(timetable: Timetable) -> list[Part]:
    return list(timetable.wiring.parts.values())


def _doing(file: Path, timetable: Timetable) -> tuple[str, str]:
    """Return the FMU that is being called and the call."""
    names = list(timetable.wiring.parts)
    with suppress(OSError):
        doing = noted(file)
        if 0 <= doing.part < len(names) and doing.code in CALLS:
            return names[doing.part], CALLS[doing.code]
        if doing.part == NOBODY:
            name, _, call = doing.text.decode("utf-8", "replace").partition("\n")
            return name, call
    return THE_RUN, "its own work"


def _died(child: Child, file: Path, timetable: Timetable) -> SimulationError:
    how = "is damaged" if child.damaged else f"ended with {how_ended(child.join(5.0))}"
    where, call = _doing(file, timetable)
    if where in timetable.wiring.parts:
        where += f" ({timetable.wiring.parts[where].fmu.path.name})"
    inside = " and ".join(_foreign(timetable.wiring.system))
    return SimulationError(
        f"{where}: the process of the run {how} during {call}; isolation = "
        f'"none" lets {inside} into it: leave that out for a process of its own'
    )


def _serve(
    pipe: Any,
    simulate: Callable[..., Result],
    system: System,
    folder: Path,
    executor: str | None,
) -> None:
    """Simulate, in the child."""
    stand_alone()
    if guards():
        stand_guard(sweep)
    else:
        Thread(target=_end_with_parent, daemon=True).start()
    mp.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    _INSIDE.append(True)
    keep(folder / NOTES)

    def tell(kind: str, value: Any) -> None:
        with suppress(OSError):
            pipe.send_bytes(encode(kind, value))

    def reached(t: Fraction) -> None:
        tell("reached", f"{t.numerator}/{t.denominator}")

    said: list[str] = []

    def recorded(result: Result) -> None:
        said[:] = [*warnings]
        for text in said:
            tell("warned", text)
        tell("finished", result)

    with collecting() as warnings:
        options = {"progress": reached, "executor": executor, "recorded": recorded}
        try:
            simulate(system, folder, **options)
        except FeedDriveError as error:
            tell("error", error)
        except Exception as error:  # what is inside may have spoilt anything
            inside = " and ".join(_foreign(system))
            tell(
                "error",
                SimulationError(
                    f"the run with {inside} inside failed: {type(error).__name__}: "
                    f'{error}; leave out isolation = "none"'
                ),
            )
    for text in warnings[len(said) :]:
        tell("warned", text)
    sys.stderr.flush()
    os._exit(0)


def _end_with_parent() -> None:
    parent = mp.parent_process()
    assert parent is not None
    mp.connection.wait([parent.sentinel])
    if mark := os.environ.get(MARK):
        end_marked(mark)
    os._exit(1)
