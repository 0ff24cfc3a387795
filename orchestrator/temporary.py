"""Temporary folders that do not outlive their run, even when it is killed.

Each holds a file that its owner keeps locked; the system drops the lock however
the owner ends.  ``sweep``, called before a new folder is made, deletes folders
whose lock is free.
"""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from time import time

PREFIX = "feeddrive-run-"
LOCK = ".in-use"
YOUNG = 600.0  # s; a folder without its lock file may just be in the making


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Give a new folder; delete it afterwards."""
    _sweep_once()
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    lock = os.open(folder / LOCK, os.O_CREAT | os.O_RDWR, 0o600)
    try:
        _take(lock)
        yield folder
    finally:
        os.close(lock)
        shutil.rmtree(folder, ignore_errors=True)


def sweep() -> None:
    """Delete the folders of runs that are dead."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            if _is_dead(folder):
                shutil.rmtree(folder, ignore_errors=True)


@cache
def _sweep_once() -> None:
    sweep()


def _is_dead(folder: Path) -> bool:
    if not folder.is_dir() or folder.is_symlink():
        return False
    try:
        lock = os.open(folder / LOCK, os.O_RDWR)
    except FileNotFoundError:
        return time() - folder.stat().st_mtime > YOUNG
    try:
        _take(lock)
    except OSError:
        return False
    finally:
        os.close(lock)
    return True


def _take(lock: int) -> None:
    """Lock a file, or raise OSError where another process has."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
