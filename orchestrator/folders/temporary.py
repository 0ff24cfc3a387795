"""Temporary folders that do not outlive their run, even when it is killed.

Each holds a file that its owner keeps locked; the system drops the lock however
the owner ends.  ``sweep``, called before a new folder is made, deletes folders
whose lock is free.
"""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from time import sleep, time

from orchestrator.folders.held import LOCK, held, is_held

PREFIX = "feeddrive-run-"
YOUNG = 600.0  # s; a folder without its lock file may just be in the making


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Give a new folder; delete it afterwards."""
    _sweep_once()
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    try:
        with held(folder):
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def sweep() -> None:
    """Delete the folders of runs that are dead."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            if _is_dead(folder):
                shutil.rmtree(folder, ignore_errors=True)


def sweep_when_free(folder: Path) -> None:
    """Delete the folder of a run that has just died, whose lock is about to fall."""
    for _ in range(1000):
        sweep()
        if not folder.exists():
            break
        sleep(0.01)


@cache
def _sweep_once() -> None:
    sweep()


def _is_dead(folder: Path) -> bool:
    if not folder.is_dir() or folder.is_symlink():
        return False
    if not (folder / LOCK).exists():
        return time() - folder.stat().st_mtime > YOUNG
    return not is_held(folder)
