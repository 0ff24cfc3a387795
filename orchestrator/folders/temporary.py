"""Temporary folders that do not outlive their run, even when it is killed.

Each is held by its owner (``orchestrator.folders.held``).  ``sweep``, called before
a new folder is made, deletes those that nobody holds, and holds them meanwhile: who
had just made one, and not yet taken it, makes another.
"""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from time import sleep, time

from orchestrator.folders.held import LOCK, FolderHeld, held

PREFIX = "feeddrive-run-"
YOUNG = 600.0  # s; a folder without its lock file may just be in the making


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Give a new folder; delete it afterwards."""
    _sweep_once()
    with ExitStack() as stack:
        folder = _taken(stack)
        try:
            yield folder
        finally:
            stack.close()
            shutil.rmtree(folder, ignore_errors=True)


def _taken(stack: ExitStack) -> Path:
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        try:
            stack.enter_context(held(folder))
        except FolderHeld:  # somebody took it for one that was left
            continue
        return folder


def sweep() -> None:
    """Delete the folders of runs that are dead."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            _delete_if_left(folder)


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


def _delete_if_left(folder: Path) -> None:
    if not folder.is_dir() or folder.is_symlink():
        return
    if not (folder / LOCK).exists():
        if time() - folder.stat().st_mtime > YOUNG:
            shutil.rmtree(folder, ignore_errors=True)
        return
    with held(folder, patience=0):
        shutil.rmtree(folder, ignore_errors=True)
    (folder / LOCK).unlink()  # Windows deletes no file that is open
    folder.rmdir()
