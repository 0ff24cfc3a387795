"""What watches the calls of a sandboxed process: it runs in the process's guard.

For each watched call the kernel asks here first.  A path inside what may be read or
written lets the call go on, and Landlock has the last word on where it leads; all else
is refused with EPERM and told to the master: the call, and the path if it has one.
"""

import ctypes
import fcntl
import json
import os
import socket
import stat
import struct
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from orchestrator.instances.syscalls import WRITES_TWO, numbers

RECEIVE, SEND = 0xC0502100, 0xC0182101  # ioctl of seccomp's notifications
ASKED = struct.Struct("=QIIiIQ6Q")  # id, process, flags; number, machine, place, six
ANSWER = struct.Struct("=QqiI")  # id, value, error, flags
GO_ON, EPERM = 1, 1
TOLD = 50  # denials that are told; an FMU may try for ever
LONGEST = 4096  # bytes of a path
HERE = -100  # AT_FDCWD


class Supervisor:
    """``descriptor`` is readable when ``serve`` has something to do."""

    def __init__(self, sandboxed: socket.socket, denials: Any) -> None:
        self._socket: socket.socket | None = sandboxed
        self._denials, self._told = denials, set[str]()
        self.descriptor = sandboxed.fileno()
        self._calls = numbers()

    @property
    def held(self) -> tuple[int, int]:
        """Descriptors that it needs."""
        return self.descriptor, int(self._denials.fileno())

    def serve(self) -> bool:
        """Take what is to watch, or answer one call; tell if there may be more."""
        if self._socket is not None:
            return self._begin(self._socket)
        asked = bytearray(ASKED.size)
        try:
            fcntl.ioctl(self.descriptor, RECEIVE, asked, True)
        except OSError:  # who called is gone
            return True
        id_, process, _, number, _, _, *arguments = ASKED.unpack(asked)
        name, kind = self._calls.get(number, (f"call {number}", "denied"))
        try:
            denied = self._judge(name, kind, process, arguments)
        except (OSError, ValueError):  # its memory cannot be read
            denied = name
        if denied:
            self._tell(denied)
        flags, error = (0, -EPERM) if denied else (GO_ON, 0)
        with suppress(OSError):
            answer = bytearray(ANSWER.pack(id_, 0, error, flags))
            fcntl.ioctl(self.descriptor, SEND, answer, True)
        return True

    def _begin(self, sandboxed: socket.socket) -> bool:
        data, found, *_ = socket.recv_fds(sandboxed, 1 << 16, 1)
        if not found:
            return False
        told = json.loads(data)
        self._read = [Path(path) for path in (*told["read"], told["write"])]
        self._write = [Path(told["write"]), *map(Path, told["devices"])]
        (self.descriptor,) = found
        sandboxed.close()
        self._socket = None
        return True

    def _judge(
        self, name: str, kind: str, process: int, arguments: Sequence[int]
    ) -> str:
        """Return what is denied in words; empty if nothing is."""
        if kind == "clone":
            return "fork"
        if name in ("execve", "execveat"):
            at = 1 if name == "execveat" else 0
            return f"{name} {_text(process, arguments[at])}"
        if kind not in ("open", "openat", "plain", "at"):
            return name
        first = 1 if kind in ("openat", "at") else 0
        if kind in ("plain", "at"):
            for place in WRITES_TWO.get(name, (first,)):
                path = _path(process, kind, arguments, place, name == "truncate")
                if not _inside(path, self._write):
                    return f"{name} {path}"
            return ""
        flags = arguments[first + 1]
        if name == "openat2":
            flags = struct.unpack("=Q", _memory(process, flags, 8))[0]
        path = _path(process, kind, arguments, first, not flags & os.O_NOFOLLOW)
        writes = flags & (os.O_ACCMODE | os.O_CREAT | os.O_TRUNC)
        if writes and not _inside(path, self._write):
            return f"open {path} to write"
        if writes or _inside(path, self._read) or not path.exists():
            return ""
        own = path.is_relative_to(f"/proc/{process}")
        return "" if own else f"open {path} to read"

    def _tell(self, denied: str) -> None:
        if denied in self._told or len(self._told) >= TOLD:
            return
        self._told.add(denied)
        with suppress(OSError):
            self._denials.send_bytes(denied.encode("utf-8", "backslashreplace"))


def _inside(path: Path, roots: Sequence[Path]) -> bool:
    return any(path.is_relative_to(root) for root in roots)


def _path(
    process: int, kind: str, arguments: Sequence[int], place: int, follow: bool
) -> Path:
    """Return the path that an argument names, links resolved."""
    text = _text(process, arguments[place])
    base = Path(f"/proc/{process}/cwd")
    if kind in ("openat", "at"):
        folder = ctypes.c_int32(arguments[place - 1] & 0xFFFFFFFF).value
        if folder != HERE:
            base = Path(f"/proc/{process}/fd/{folder}")
    text = text.replace("/proc/self", f"/proc/{process}", 1)
    whole = Path(text) if text.startswith("/") else base.readlink() / text
    with suppress(OSError):
        if follow and not stat.S_ISFIFO(whole.lstat().st_mode):
            return whole.resolve()
    return whole.parent.resolve() / whole.name


def _text(process: int, place: int) -> str:
    data = b""
    while len(data) < LONGEST and b"\0" not in data:
        page = 4096 - (place + len(data)) % 4096  # the next one may not be there
        data += _memory(process, place + len(data), page)
    return os.fsdecode(data.partition(b"\0")[0])


def _memory(process: int, place: int, size: int) -> bytes:
    with Path(f"/proc/{process}/mem").open("rb", buffering=0) as memory:
        memory.seek(place)
        return memory.read(size)
