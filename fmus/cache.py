"""Where built FMUs, libraries and what was computed once are kept.

An entry is a folder of files with the SHA-256 of each (``DIGESTS``, as sha256sum
writes it).  It appears whole or not at all, by a rename after all of it is on the
disk; the first of several writers wins.  What is no longer as it was written is not
used: it goes, with a note, and is made anew.
"""

import logging
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from errno import ENOENT
from hashlib import file_digest
from pathlib import Path
from time import time

import platformdirs

LOG = logging.getLogger("feeddrive")
DIGESTS = "sha256"  # file of an entry
BUILDING = ".building-"  # folders where entries are made
LEFT = 3600.0  # s after which a folder of these was left by a process that was killed


def cache_folder() -> Path:
    """Return the user's cache folder, or the one that FEEDDRIVE_CACHE names.

    Raises:
        OSError: there is neither.
    """
    if chosen := os.environ.get("FEEDDRIVE_CACHE"):
        return Path(chosen)
    try:
        return platformdirs.user_cache_path("feeddrive")
    except RuntimeError:
        why = "this user has no home folder; name one for what is built"
        raise OSError(ENOENT, why, "FEEDDRIVE_CACHE") from None


def digest(file: Path) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with file.open("rb") as opened:
        return file_digest(opened, "sha256").hexdigest()


def entry(place: Path) -> dict[str, Path]:
    """Return the files of an entry by name, none if it is not there or not whole."""
    if not place.is_dir():
        return {}
    try:
        lines = (place / DIGESTS).read_text(encoding="utf-8").splitlines()
        noted = {name: found for found, _, name in (x.partition("  ") for x in lines)}
        if noted and all(digest(place / name) == noted[name] for name in noted):
            return {name: place / name for name in noted}
    except (OSError, UnicodeDecodeError):
        pass
    LOG.warning("%s: is damaged in the cache, so it is made anew", place)
    with building(place.parent) as aside, suppress(FileNotFoundError):
        place.rename(aside / "damaged")  # at once, whoever looks meanwhile
    return {}


@contextmanager
def building(parent: Path) -> Iterator[Path]:
    """Give a folder of its own inside the cache, so that renames are atomic."""
    parent.mkdir(parents=True, exist_ok=True)
    for left in parent.glob(f"{BUILDING}*"):
        with suppress(OSError):
            if time() - left.stat().st_mtime > LEFT:
                shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(
        dir=parent, prefix=BUILDING, ignore_cleanup_errors=True
    ) as folder:
        yield Path(folder)


def publish(files: Sequence[Path], place: Path) -> None:
    """Move files of one folder into an entry that appears at once.

    Raises:
        OSError: they cannot be written there; it names the entry.
    """
    ready = files[0].parent / ".ready"
    try:
        ready.mkdir()
        for file in files:
            on_disk(file)
            file.rename(ready / file.name)
        told = "".join(f"{digest(ready / f.name)}  {f.name}\n" for f in files)
        (ready / DIGESTS).write_text(told, encoding="utf-8")
        for written in (ready / DIGESTS, ready):
            on_disk(written)
        try:
            ready.rename(place)
        except OSError:
            if not place.exists():
                raise
        on_disk(place.parent)
    except OSError as error:  # which need not name a file
        raise OSError(error.errno, error.strerror, str(place)) from None


def on_disk(path: Path) -> None:
    """Wait until a file or the names in a folder are on the disk."""
    if sys.platform == "win32" and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
