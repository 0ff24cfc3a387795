"""Carry out the items: static ones here, each dynamic one in a process of its own.

A dynamic item gets a child that is killed when its time is over; what the child
wrote to stdout or stderr is kept from ours.  A crash, an exit or a hang of an
FMU is a finding that names what was being tried; a slow FMU, or a busy machine, is
none (``patience``).  If the library cannot be loaded, the other dynamic items are
not tried.
"""

import ctypes
import multiprocessing as mp
import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from orchestrator.checks.archive import Archive
from orchestrator.checks.catalogue import catalogue
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    Item,
    NotApplicable,
    Outcome,
    Said,
)
from orchestrator.checks.patience import Patience
from orchestrator.checks.report import Report
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import unpacked

LOOK = 0.2  # s between two looks at a child
LOADS = 11  # the dynamic item without which no other is tried
NO_LIBRARY = "does not load|cannot load|while loading the library"
WORKERS = 2
STARTING = "starting its process"


def check_fmu(
    path: Path,
    *,
    only: Iterable[int] = (),
    dynamic: bool = True,
    progress: Callable[[Item], None] = lambda item: None,
) -> Report:
    """Carry out the items on an FMU file.

    ``only`` chooses item numbers; without ``dynamic`` nothing of the FMU is run.
    ``progress`` is told each item before it begins.

    Raises:
        FmuError: there is no such file.
    """
    if not path.is_file():
        raise FmuError(f"{path}: no such file; give the path of an .fmu file")
    chosen = set(only) or {item.number for item in catalogue()}
    items = [item for item in catalogue() if item.number in chosen]
    archive = Archive(path)
    outcomes = []
    for item in items:
        if item.part == "static":
            progress(item)
            outcomes.append(_static(item, archive))
    tried = [item for item in items if item.part == "dynamic"]
    if dynamic and tried:
        outcomes += _dynamic(tried, archive, progress)
    outcomes.sort(
        key=lambda outcome: (outcome.item.number, outcome.item.part[0] != "s")
    )
    return Report(path, tuple(outcomes))


def _static(item: Item, archive: Archive) -> Outcome:
    outcome = Outcome(item)
    try:
        for said in item.stages[0](archive):
            _note(outcome, said)
    except NotApplicable as error:
        outcome.reason, outcome.verdict = str(error), "not applicable"
    except CannotRun as error:
        if item.number == 1:  # an archive that cannot be opened is the fault itself
            outcome.findings.append(Finding(str(error)))
        else:
            outcome.reason, outcome.verdict = str(error), "could not be run"
    except Exception as error:  # what a document without a schema may lead to
        fault = f"{type(error).__name__}: {error}"
        outcome.reason = f"the FMU's files do not make sense here ({fault}); see item 2"
        outcome.verdict = "could not be run"
    return _judged(outcome)


def _note(outcome: Outcome, said: Said) -> None:
    if isinstance(said, Finding):
        outcome.findings.append(said)
    else:
        outcome.seen.append(said)


def _judged(outcome: Outcome) -> Outcome:
    """Findings are the verdict, but no advice hides that the rest was not tried."""
    stopped = outcome.verdict == "could not be run"
    if any(f.severity == "error" for f in outcome.findings) or not stopped:
        outcome.verdict = "finding" if outcome.findings else outcome.verdict
    return outcome


def _dynamic(
    items: list[Item], archive: Archive, progress: Callable[[Item], None]
) -> list[Outcome]:
    def refused(reason: str) -> list[Outcome]:
        return [Outcome(i, reason=reason, verdict="could not be run") for i in items]

    try:
        _ = archive.description, archive.model
    except CannotRun as error:
        return refused(str(error))
    try:
        with unpacked(archive.path) as folder:
            gate = next(i for i in catalogue() if i.key == f"{LOADS}D")
            progress(gate)
            first = _tried(gate, archive.path, folder)
            rest = [item for item in items if item is not gate]
            if any(re.search(NO_LIBRARY, f.text) for f in first.findings):
                reason = "; ".join(f.text for f in first.findings)
                outcomes = [
                    Outcome(i, reason=reason, verdict="could not be run") for i in rest
                ]
            elif first.verdict in ("could not be run", "not applicable"):
                outcomes = [
                    Outcome(i, reason=first.reason, verdict=first.verdict) for i in rest
                ]
            else:
                with ThreadPoolExecutor(WORKERS) as pool:

                    def one(item: Item) -> Outcome:
                        progress(item)
                        return _tried(item, archive.path, folder)

                    outcomes = list(pool.map(one, rest))
            return [*outcomes, first] if gate in items else outcomes
    except FmuError as error:
        return refused(str(error))


@dataclass
class _Heard:
    """What a child said until it ended."""

    said: list[Said] = field(default_factory=list)
    trying: str = STARTING
    kept: dict[str, Any] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    end: str = ""
    reason: str = ""


def _tried(item: Item, path: Path, folder: Path) -> Outcome:
    """Run the stages of a dynamic item, each in a fresh child."""
    outcome = Outcome(item)
    kept: dict[str, Any] = {}
    for stage in range(len(item.stages)):
        heard = _in_child(item, stage, path, folder, kept)
        for said in heard.said:
            _note(outcome, said)
        kept = heard.kept
        outcome.notes += [n for n in heard.notes.values() if n not in outcome.notes]
        if heard.end in ("not applicable", "could not be run"):
            outcome.reason, outcome.verdict = heard.reason, heard.end  # type: ignore[assignment]
            break
        if heard.end != "done":
            outcome.findings.append(Finding(heard.reason))
            break
    return _judged(outcome)


def _in_child(
    item: Item, stage: int, path: Path, folder: Path, kept: dict[str, Any]
) -> _Heard:
    context = _context()
    ours, theirs = context.Pipe(duplex=False)
    beats = context.RawValue(ctypes.c_ulonglong, 0)
    arguments = (theirs, beats, item.key, stage, path, folder, kept)
    child: Any = context.Process(target=serve, args=arguments, daemon=True)
    child.start()
    theirs.close()
    heard = _Heard()
    patience = Patience(child.pid, item.seconds)
    try:
        while not heard.end:
            if ours.poll(LOOK):
                _hear(heard, *ours.recv())
            over = patience.over(beats.value, heard.trying != STARTING)
            if over and not heard.end:
                heard.end, heard.reason = over.verdict, over.text(heard.trying)
    except (EOFError, OSError):
        child.join(5)
        heard.end, heard.reason = "died", f"{_how(child)} while {heard.trying}"
        if heard.trying == STARTING:  # nothing of the FMU has been touched yet
            heard.end = "could not be run"
    finally:
        child.join(5) if heard.end in ("done", "died", "refused") else child.kill()
        if child.is_alive():
            child.kill()
        child.join()
        ours.close()
    return heard


def _hear(heard: _Heard, kind: str, value: Any) -> None:
    if kind == "said":
        heard.said.append(value)
    elif kind == "trying":
        heard.trying = value
    elif kind == "notes":
        heard.notes |= value
    elif kind == "done":
        heard.end, heard.kept = "done", value
    else:
        heard.end, heard.reason = kind, value


def _how(child: Any) -> str:
    code = child.exitcode
    if code is not None and code < 0:
        return f"the process crashed with {signal.Signals(-code).name}"
    return f"the process ended with exit code {code}"


def _context() -> Any:
    """Return a way to start clean processes, quick where the system has one."""
    if "forkserver" not in mp.get_all_start_methods():
        return mp.get_context("spawn")
    context = mp.get_context("forkserver")
    context.set_forkserver_preload(["orchestrator.checks.engine"])
    return context


def serve(
    pipe: Any,
    beats: Any,
    key: str,
    stage: int,
    path: Path,
    folder: Path,
    kept: dict[str, Any],
) -> None:
    """Carry out one stage of one dynamic item; runs in the child."""
    from fmpy.fmi1 import FMICallException

    from orchestrator.checks.laboratory import Laboratory
    from orchestrator.instances.group import told

    printed = _hide_output()
    last = [STARTING]

    def tell(text: str) -> None:
        last[0] = text
        pipe.send(("trying", text))

    def beat() -> None:
        beats.value += 1

    item = next(i for i in catalogue() if i.key == key)
    archive = Archive(path)
    lab = Laboratory(
        archive.description,
        archive.model,
        folder,
        tell,
        printed,
        dict(kept),
        beat=beat,
    )
    try:
        for said in item.stages[stage](lab):
            pipe.send(("said", said))
        pipe.send(("notes", lab.notes))
        pipe.send(("done", lab.kept))
    except NotApplicable as error:
        pipe.send(("not applicable", str(error)))
    except CannotRun as error:
        pipe.send(("could not be run", str(error)))
    except FMICallException as error:
        label = told(error.status)
        pipe.send(("refused", f"{error.function} returned {label} while {lab.blamed}"))
    except Exception as error:
        fault = f"a fault in feeddrive while {last[0]}: {type(error).__name__}: {error}"
        pipe.send(("could not be run", fault))
    # Not by the interpreter's way out: an FMU's libraries may not survive it.
    sys.stdout.flush()
    os._exit(0)


def _hide_output() -> Callable[[], bytes]:
    """Send what the FMU prints into a file; return a function that reads it."""
    file = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process
    os.dup2(file.fileno(), 1)
    os.dup2(file.fileno(), 2)

    def printed() -> bytes:
        file.seek(0)
        return file.read()

    return printed
