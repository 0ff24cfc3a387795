"""What an FMU of this process is being asked, in a file that outlives the process.

For a run that lets an FMU of others into its process (``isolation = "none"``): when
that takes the process along, whoever waits for it reads here which FMU it was.
Without ``keep`` nothing is noted.
"""

import ctypes
import mmap
from pathlib import Path
from typing import Any, ClassVar

NOBODY = -1
THE_RUN = "the run"


class Doing(ctypes.Structure):
    """The kernel notes part and operation, all others a text; both count."""

    _fields_: ClassVar[Any] = [
        ("part", ctypes.c_int32),
        ("code", ctypes.c_int32),
        ("count", ctypes.c_uint32),
        ("text", ctypes.c_char * 244),
    ]


_KEPT: list[tuple[Doing, mmap.mmap]] = []


def keep(file: Path) -> None:
    """Note from now on in a file."""
    file.write_bytes(bytes(ctypes.sizeof(Doing)))
    with file.open("r+b") as opened:
        memory = mmap.mmap(opened.fileno(), ctypes.sizeof(Doing))
    _KEPT[:] = [(Doing.from_buffer(memory), memory)]
    rest()


def rest() -> None:
    """Note that no FMU is being called."""
    mark(THE_RUN, "its own work")


def mark(name: str, call: str) -> None:
    """Note that an FMU is being called."""
    for doing, _ in _KEPT:
        doing.part, doing.count = NOBODY, doing.count + 1
        doing.text = f"{name}\0{call}".encode()[:243].replace(b"\0", b"\n", 1)


def place() -> int | None:
    """Return where the kernel notes part, operation, count; None if nobody asks."""
    return ctypes.addressof(_KEPT[0][0]) if _KEPT else None


def noted(file: Path) -> Doing:
    """Return what a process noted last."""
    data = file.read_bytes()[: ctypes.sizeof(Doing)]
    return Doing.from_buffer_copy(data.ljust(ctypes.sizeof(Doing), b"\0"))
