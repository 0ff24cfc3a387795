"""A folder that its owner keeps locked for as long as it lives.

The system drops the lock however the owner ends, so that nothing left behind by
a process that was killed passes for one under way.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

LOCK = ".in-use"
PATIENCE = 2.0  # s; whoever only looks holds it for a moment, longer where all are busy


class FolderHeld(OSError):
    """Another process, or another place of this one, holds or has deleted it."""


@contextmanager
def held(folder: Path, patience: float = PATIENCE) -> Iterator[None]:
    """Hold a folder, waiting ``patience`` (s) for it.

    Raises:
        FolderHeld: another process, or another place of this one, holds it, or held
            it and has deleted it.
        OSError: nothing can be written there.
    """
    lock = os.open(folder / LOCK, os.O_CREAT | os.O_RDWR, 0o600)
    try:
        _take_soon(lock, patience)
        if not _is_in(lock, folder):
            raise FolderHeld("another process deleted this folder")
        yield
    finally:
        os.close(lock)


def is_held(folder: Path) -> bool:
    """Tell whether somebody holds a folder.

    Raises:
        OSError: the folder cannot be looked into.
    """
    try:
        lock = os.open(folder / LOCK, os.O_RDWR)
    except FileNotFoundError:
        return False
    try:
        _take(lock)
    except OSError:
        return True
    finally:
        os.close(lock)
    return False


def _take_soon(lock: int, patience: float) -> None:
    end = monotonic() + patience
    while True:
        try:
            return _take(lock)
        except OSError:
            if monotonic() > end:
                raise FolderHeld("another process holds this folder") from None
        sleep(0.01)


def _is_in(lock: int, folder: Path) -> bool:
    """Tell whether the lock that is held is the one others find in the folder."""
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(lock), (folder / LOCK).stat())
    return False


def _take(lock: int) -> None:
    """Lock a file, or raise OSError where it is locked already."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
