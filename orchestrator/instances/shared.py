"""Memory that a master and the process of an FMU map: a header, then values.

On Linux it is a sealed memfd, which no FMU can cut short under its master, and
which has no descriptor any more once it is mapped.  The values end at a page that
nobody may touch, with another before them: in the process of the FMU, what writes
beyond them crashes where it does.  Elsewhere it is a file in the folder of the FMU.
"""

import ctypes
import mmap
import os
import sys
from multiprocessing import reduction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.native import library as c

CHANNEL = "feeddrive-channel"  # file in the folder of the FMU
PAGE = mmap.PAGESIZE
SEALED = sys.platform == "linux"
ADD_SEALS, SEALS = 1033, 1 | 2 | 4  # F_ADD_SEALS: no more seals, no less, no more
NOTHING, READ_AND_WRITE, SHARED = 0, 1 | 2, 1  # PROT_NONE and so on


class Shared:
    """The mapped memory: ``channel`` is the header, ``values`` what follows."""

    def __init__(self, descriptor: int, n_values: int) -> None:
        size = _size(n_values)
        self._memory: Any = _Mapped(descriptor, size) if SEALED else None
        if self._memory is None:
            self._memory = mmap.mmap(descriptor, size)
        data = self._memory.data if SEALED else self._memory
        self.channel = c.Channel.from_buffer(data)
        self.values: NDArray[np.float64] = np.frombuffer(
            data, offset=size - PAGE - 8 * n_values, count=n_values
        )

    @classmethod
    def made(cls, n_values: int, folder: Path, pipe: Any, process: int) -> "Shared":
        """Make it in the master and hand it to a process, which gets it with ``given``.

        The process has been told to expect it.
        """
        size = _size(n_values)
        if not SEALED:
            with (folder / CHANNEL).open("x+b") as file:
                file.write(bytes(size))  # its space is taken now, not at a later fault
                file.flush()
                pipe.send(n_values)
                return cls(file.fileno(), n_values)
        import fcntl

        descriptor = os.memfd_create("feeddrive", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(descriptor, size)
            os.posix_fallocate(descriptor, 0, size)
            fcntl.fcntl(descriptor, ADD_SEALS, SEALS)
            pipe.send(n_values)
            reduction.send_handle(pipe, descriptor, process)
            return cls(descriptor, n_values)
        finally:
            os.close(descriptor)

    @classmethod
    def given(cls, folder: Path, pipe: Any) -> "Shared":
        """Map, in the process of the FMU, what the master made."""
        n_values = int(pipe.recv())
        if not SEALED:
            with (folder / CHANNEL).open("r+b") as file:
                return cls(file.fileno(), n_values)
        descriptor = reduction.recv_handle(pipe)
        try:
            shared = cls(descriptor, n_values)
        finally:
            os.close(descriptor)
        for guard in (_header(), _size(n_values) - PAGE):
            shared._memory.forbid(guard)
        return shared

    @property
    def place(self) -> int:
        """Address of the values."""
        return int(self.values.ctypes.data)

    def close(self) -> None:
        """Unmap it; nothing may refer to it any more."""
        del self.channel, self.values
        self._memory.close()


class _Mapped:
    """Mapped memory; Python's own mapping would keep a descriptor of it."""

    def __init__(self, descriptor: int, size: int) -> None:
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._libc.mmap.restype = ctypes.c_void_p
        place, offset = ctypes.c_void_p(None), ctypes.c_long(0)
        self._size, self._address = ctypes.c_size_t(size), ctypes.c_void_p(None)
        address = self._libc.mmap(
            place, self._size, READ_AND_WRITE, SHARED, descriptor, offset
        )
        if address in (None, ctypes.c_void_p(-1).value):
            raise OSError(ctypes.get_errno(), "mmap")
        self._address = ctypes.c_void_p(address)
        self.data: Any = (ctypes.c_char * size).from_address(address)

    def forbid(self, offset: int) -> None:
        """Let nobody touch the page that begins there."""
        place = ctypes.c_void_p((self._address.value or 0) + offset)
        if self._libc.mprotect(place, ctypes.c_size_t(PAGE), NOTHING):
            raise OSError(ctypes.get_errno(), "mprotect")

    def close(self) -> None:
        del self.data
        self._libc.munmap(self._address, self._size)


def _header() -> int:
    return _pages(ctypes.sizeof(c.Channel))


def _size(n_values: int) -> int:
    """Bytes of header, page, values to the end of theirs, and page."""
    return _header() + PAGE + max(PAGE, _pages(8 * n_values)) + PAGE


def _pages(size: int) -> int:
    return -(-size // PAGE) * PAGE
