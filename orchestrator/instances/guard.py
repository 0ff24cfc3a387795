"""The parent of a process that FMUs of others run in: it holds none of their code.

On Linux ``stand_guard`` splits a process in two.  The one that goes on is killed by
the system when its guard ends, whatever an FMU does in it.  The guard gets every
process that was left by its own parent (it is their subreaper), so that nothing can
leave it; when the process it guards ends, or the master does, or asks for it by
SIGTERM, it kills what is left and ends as the process did.  What it prints goes through
the guard, which shows control characters instead of passing them to a terminal.
"""

import ctypes
import multiprocessing as mp
import os
import resource
import select
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from time import sleep
from typing import Any, NoReturn

from orchestrator.errors import shown
from orchestrator.instances.supervisor import Supervisor

PDEATHSIG, SUBREAPER = 1, 36  # of prctl
ROUNDS, PAUSE = 400, 0.005  # of killing, with seconds between: at most 2 s
MOST = 65536  # bytes that are printed at once: what a pipe holds
LEFT = 1  # exit code where the master has gone


class _Asked(Exception):
    """The master wants an end."""


@cache
def guards() -> bool:
    """Tell whether there are guards here: some containers forbid what they need."""
    if sys.platform != "linux" or not hasattr(os, "pidfd_open"):
        return False
    try:
        os.close(os.pidfd_open(os.getpid()))
    except OSError:
        return False
    return True


def stand_guard(
    cleared: Callable[[], None], denials: Any = None
) -> socket.socket | None:
    """Split this process; the caller's goes on in the guarded one.

    With ``denials``, a connection to the master, the guard watches a sandbox, which is
    entered with the socket that is returned.

    ``cleared`` is called in the guard when the master has gone and nothing that it
    guards is left.
    """
    master = mp.parent_process()
    assert master is not None
    assert master.pid is not None
    try:
        watched = os.pidfd_open(master.pid)
    except OSError:
        os._exit(LEFT)
    if os.getppid() != master.pid:
        os._exit(LEFT)
    prctl = ctypes.CDLL(None).prctl
    prctl(SUBREAPER, 1, 0, 0, 0)
    guard = os.getpid()
    printed, printing = os.pipe()
    ours = theirs = None
    if denials is not None:
        ours, theirs = socket.socketpair()
    guarded = os.fork()
    if guarded:
        supervisor = None
        if ours is not None:
            supervisor = Supervisor(ours, denials)
        _guard(guarded, watched, printed, supervisor, cleared)
    prctl(PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    for descriptor in (1, 2):
        os.dup2(printing, descriptor)
    for descriptor in (watched, printed, printing):
        os.close(descriptor)
    if ours is not None:
        ours.close()
        denials.close()
    if os.getppid() != guard:
        os._exit(LEFT)
    return theirs


def _guard(
    guarded: int,
    watched: int,
    printed: int,
    supervisor: Supervisor | None,
    cleared: Callable[[], None],
) -> NoReturn:
    """Wait for an end; leave nothing."""
    code = -signal.SIGKILL
    try:
        code = _watch(guarded, watched, printed, supervisor, cleared)
    finally:
        if code < 0:
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            with suppress(OSError):  # SIGKILL cannot be handled anyway
                signal.signal(-code, signal.SIG_DFL)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [-code])
            os.kill(os.getpid(), -code)
        os._exit(code)


def _watch(
    guarded: int,
    watched: int,
    printed: int,
    supervisor: Supervisor | None,
    cleared: Callable[[], None],
) -> int:
    ends: dict[int, int] = {}

    def reap(*_: object) -> None:
        with suppress(ChildProcessError):
            while (found := os.waitpid(-1, os.WNOHANG))[0]:
                ends[found[0]] = os.waitstatus_to_exitcode(found[1])

    def asked(*_: object) -> None:
        raise _Asked

    end = os.pidfd_open(guarded)
    terminal = os.dup(2)
    held = supervisor.held if supervisor else ()
    _hold_nothing_but(watched, printed, terminal, end, *held)
    os.set_blocking(printed, False)
    signal.signal(signal.SIGCHLD, reap)
    gone = False
    try:
        signal.signal(signal.SIGTERM, asked)
        waiting = select.poll()
        for descriptor in (watched, printed, end):
            waiting.register(descriptor, select.POLLIN)
        ready = {printed: 0}
        if supervisor:
            waiting.register(supervisor.descriptor, select.POLLIN)
        while not ready.keys() & {watched, end}:
            ready = dict(waiting.poll())
            if printed in ready and not _show(printed, terminal):
                waiting.unregister(printed)
            if supervisor and supervisor.descriptor in ready:
                _supervise(supervisor, waiting, ready[supervisor.descriptor])
        gone = watched in ready
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    except _Asked:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for _ in range(ROUNDS):
        for process in _descendants():
            with suppress(OSError):
                os.kill(process, signal.SIGKILL)
        reap()
        if not _has_children():
            break
        sleep(PAUSE)
    _show(printed, terminal)
    if gone:
        cleared()
        return LEFT
    return ends.get(guarded, -signal.SIGKILL)


def _supervise(supervisor: Supervisor, waiting: Any, event: int) -> None:
    waiting.unregister(supervisor.descriptor)
    if event & select.POLLIN and supervisor.serve():
        waiting.register(supervisor.descriptor, select.POLLIN)


def _show(printed: int, terminal: int) -> bool:
    """Print what the guarded process printed; tell whether there may be more."""
    data = b""
    with suppress(BlockingIOError):
        data = os.read(printed, MOST)
    text = shown(data.decode("utf-8", "backslashreplace"))
    with suppress(OSError):  # the reader is gone
        os.write(terminal, text.encode("utf-8", "backslashreplace"))
    return bool(data)


def _has_children() -> bool:
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def _hold_nothing_but(*kept: int) -> None:
    """Close what the guarded process uses: its pipe ends when that process does."""
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in range(3):
        os.dup2(nothing, descriptor)
    for name in [int(file.name) for file in Path("/proc/self/fd").iterdir()]:
        if name > 2 and name not in kept:
            with suppress(OSError):
                os.close(name)


def _descendants() -> Iterator[int]:
    """Give all processes below this one that have not ended."""
    parents = dict(_parents())
    known = {os.getpid()}
    while new := {p for p, parent in parents.items() if parent in known} - known:
        known |= new
        yield from new


def _parents() -> Iterator[tuple[int, int]]:
    """Give all processes that have not ended, with their parents."""
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, ValueError):
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            if state not in "ZX":
                yield int(folder.name), int(parent)
