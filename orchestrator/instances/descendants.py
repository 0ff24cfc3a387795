"""What an FMU has started ends with it, also what left its process group.

Every process of an FMU has a mark in its environment, which what it starts
inherits and cannot take off again.  On Linux they are found by it; elsewhere the
process group has to do.
"""

import os
import secrets
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing import resource_tracker, util
from pathlib import Path
from threading import local
from typing import Any

MARK = "FEEDDRIVE_PROCESS"
ENV = Path("/usr/bin/env")
ROUNDS = 20  # of killing: what is forked meanwhile is found in the next
_HERE = local()  # the mark that processes started by this thread get


def new_mark() -> str:
    """Return a mark that no other process has."""
    return f"{os.getpid()}-{secrets.token_hex(8)}"


@contextmanager
def marked(mark: str) -> Iterator[None]:
    """Give the processes that multiprocessing starts in this block the mark.

    Only those of this thread: what another one starts meanwhile is not the FMU's.
    """
    if sys.platform == "linux" and ENV.is_file():
        _install()
        resource_tracker.ensure_running()  # which serves all, so it has no mark
        _HERE.mark = mark
    try:
        yield
    finally:
        _HERE.mark = None


@cache
def _install() -> None:
    start: Any = util.spawnv_passfds

    def spawnv_passfds(path: Any, args: Sequence[Any], passfds: Any) -> Any:
        if mark := getattr(_HERE, "mark", None):
            path, args = ENV, ["env", f"{MARK}={mark}", *args]
        return start(os.fsencode(path), args, passfds)

    util.spawnv_passfds = spawnv_passfds


def end_marked(mark: str) -> None:
    """Kill all processes with a mark but this one."""
    for _ in range(ROUNDS):
        if not (found := list(_with(mark))):
            return
        for process in found:
            with suppress(OSError):
                os.kill(process, signal.SIGKILL)


def _with(mark: str) -> Iterator[int]:
    wanted = f"{MARK}={mark}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            words = (folder / "environ").read_bytes().split(b"\0")
            if wanted in words and int(folder.name) != os.getpid():
                yield int(folder.name)
