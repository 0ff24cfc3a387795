"""Which FMU files this machine has built: those may run in a process of ours.

That an FMU says it is ours proves nothing.  ``build`` keeps the SHA-256 of every
archive it makes in the user's cache; a file with one of these digests, wherever it
lies and whatever it is called, is what was built here.
"""

from functools import lru_cache
from pathlib import Path

from fmus.cache import cache_folder, digest


def trust(archive: Path) -> str:
    """Note that an archive was built here; return its digest."""
    found = digest(archive)
    folder = _folder()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / found).touch()
    return found


def is_trusted(file: Path) -> bool:
    """Tell whether a file is an FMU that was built here."""
    try:
        stamp = file.stat()
    except OSError:
        return False
    known = _digest(file.resolve(), stamp.st_mtime_ns, stamp.st_size, stamp.st_ino)
    return (_folder() / known).is_file()


def _folder() -> Path:
    return cache_folder() / "trusted"


@lru_cache(maxsize=256)
def _digest(file: Path, _mtime: int, _size: int, _inode: int) -> str:
    return digest(file)
