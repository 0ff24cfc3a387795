"""Opening FMU archives, which are untrusted.

Refused before a byte is written: a path that would leave the extraction
folder, links, too many files, too much data.  The folder is deleted by whoever
asked for it (``unpacked`` does so at the end of its block).
"""

import lzma
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath

from orchestrator.errors import FmuError
from orchestrator.folders.temporary import temporary_folder

# what zipfile raises on damaged data
DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error),
    *(OSError, EOFError, RuntimeError, ValueError, LookupError),
)
MAX_FILES = 20_000
MAX_BYTES = 2 << 30
MAX_TEXT = 32 << 20  # bytes of a member that is read as a whole, such as a description


def checked_members(path: Path) -> list[zipfile.ZipInfo]:
    """List the members of an FMU archive after every safety check.

    Raises:
        FmuError: no such file, not a complete zip archive, or an unsafe one.
    """
    if not path.is_file():
        raise FmuError(f"{path}: no such file; give the path of an .fmu file")
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
    except DAMAGE as error:
        raise FmuError(
            f"{path}: not a readable zip archive ({error}); it may be truncated: "
            f"export or copy it again"
        ) from None
    total = sum(member.file_size for member in members)
    if len(members) > MAX_FILES or total > MAX_BYTES:
        raise FmuError(
            f"{path}: {len(members)} files, {total / 1e6:.0f} MB unpacked; at most "
            f"{MAX_FILES} files and {MAX_BYTES / 1e6:.0f} MB are accepted"
        )
    for member in members:
        if fault := _fault(member):
            raise FmuError(
                f"{path}: member {member.filename!r} {fault}; it could write outside "
                f"its folder, so the archive is refused: get it from its supplier again"
            )
    return members


def _fault(member: zipfile.ZipInfo) -> str | None:
    name = member.orig_filename
    windows = PureWindowsPath(name)
    if not name:
        return "has an empty name"
    if PurePosixPath(name).is_absolute() or windows.drive or windows.root:
        return "has an absolute path"
    if ".." in windows.parts:
        return "climbs out of the archive with '..'"
    if "\x00" in name:
        return "has a NUL in its name"
    if stat.S_ISLNK(member.external_attr >> 16):
        return "is a symbolic link"
    return None


def read_member(path: Path, name: str) -> bytes:
    """Return one member of an FMU archive.

    Raises:
        FmuError: the archive is damaged, or has no such member, or it is too large.
    """
    sizes = {member.filename: member.file_size for member in checked_members(path)}
    if sizes.get(name, 0) > MAX_TEXT:
        raise FmuError(
            f"{path}: {name} has {sizes[name] / 1e6:.0f} MB unpacked; at most "
            f"{MAX_TEXT / 1e6:.0f} MB are accepted: ask its supplier for a smaller one"
        )
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.read(name)
    except KeyError:
        raise FmuError(
            f"{path}: has no {name}, so it is not an FMU; export it again"
        ) from None
    except DAMAGE as error:
        raise FmuError(
            f"{path}: {name} cannot be read ({error}); the archive is damaged: "
            f"export or copy it again"
        ) from None


@contextmanager
def unpacked(path: Path, without: Sequence[str] = ()) -> Iterator[Path]:
    """Unpack an FMU into a new temporary folder and delete it afterwards.

    Members whose names begin with one of ``without`` are left out.
    """
    left_out = tuple(without)
    members = [m for m in checked_members(path) if not m.filename.startswith(left_out)]
    with temporary_folder() as folder:
        try:
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder, members)
        except DAMAGE as error:
            raise FmuError(
                f"{path}: cannot be unpacked ({error}); the archive is damaged or "
                f"the disk is full"
            ) from None
        yield folder
