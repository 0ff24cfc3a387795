"""A sandbox of Linux for the process of an FMU: entered before its code is loaded.

Landlock leaves the process its own folder to write in and what programs are made of
(system libraries, Python, our packages, the cache) to read.  Seccomp lets the guard
look at every call that opens, writes or names a file, and refuses what no FMU needs:
programs, processes, sockets, signals to others, changes of rights.  Nothing of it needs
privileges, and neither can be left again.  Memory, files and descriptors have limits.

Source: Linux, Documentation/userspace-api/{landlock,seccomp_filter}.rst.
"""

import ctypes
import json
import os
import resource
import socket
import struct
import sys
import sysconfig
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from fmus.cache import cache_folder
from fmus.own import HOME
from orchestrator.errors import SimulationError
from orchestrator.instances.guard import guards
from orchestrator.instances.syscalls import (
    AUDIT_ARCH,
    CLONE3,
    X32,
    machine,
    numbers,
)

MEMORY = 4e9  # bytes beside Python's, if memory_limit does not say
LARGEST_FILE, MOST_FILES = 1 << 30, 256
SYSTEM = (
    *("/usr", "/lib", "/lib64", "/nix/store", "/etc/ld.so.cache", "/etc/localtime"),
    *("/sys/devices/system/cpu", "/proc/self", "/proc/cpuinfo", "/proc/meminfo"),
    *("/proc/stat", "/proc/sys/vm/overcommit_memory", "/dev/urandom"),
)
DEVICES = ("/dev/null", "/dev/zero")
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446  # of all machines
SECCOMP = {"x86_64": 317, "aarch64": 277}
CAPSET = {"x86_64": 126, "aarch64": 91}
# rights of Landlock by the version that brought them
RIGHTS = {1: (1 << 13) - 1, 2: 1 << 13, 3: 1 << 14, 5: 1 << 15}
READ, OF_FILES = 1 << 2 | 1 << 3, 1 | 2 | 4 | 1 << 14 | 1 << 15
NO_NEW_PRIVS = 38  # of prctl
ALLOW, ERRNO, NOTIFY, KILL = 0x7FFF0000, 0x00050000, 0x7FC00000, 0x80000000
LOAD, EQUAL, AT_LEAST, ANY_BIT, RETURN = 0x20, 0x15, 0x35, 0x45, 0x06  # of BPF
NUMBER, ARCH, FIRST = 0, 4, 16  # in what a filter sees: the low half of an argument
CLONE_THREAD, ENOSYS = 0x10000, 38


@cache
def why_not() -> str:
    """Say why there is no sandbox here; empty if there is one."""
    if sys.platform != "linux":
        return "there is one on Linux only"
    if machine() not in AUDIT_ARCH:
        return f"there is none for {machine()}"
    if not guards():
        return "this system lets no guard watch a process (pidfd_open)"
    if _syscall(CREATE_RULESET, None, 0, 1) < 1:
        return "this kernel has no Landlock (Linux 5.13, CONFIG_SECURITY_LANDLOCK)"
    actions = Path("/proc/sys/kernel/seccomp/actions_avail")
    with suppress(OSError):
        if "user_notif" in actions.read_text():
            return ""
    return "this kernel has no seccomp that asks a supervisor (Linux 5.0)"


def enter(
    folder: Path, fmu: Path, memory_limit: float | None, guard: socket.socket
) -> None:
    """Put this process, of one thread, into a sandbox that ``guard`` watches.

    ``folder`` is what it may write in; ``fmu``, its archive, it may read.

    Raises:
        SimulationError: the kernel refuses.
    """
    folder = folder.resolve()
    os.environ["TMPDIR"] = str(folder)
    sys.dont_write_bytecode = True
    readable = [path for path in (fmu.resolve(), *_readable()) if path.exists()]
    if len(list(Path("/proc/self/task").iterdir())) > 1:
        raise SimulationError("sandbox: a thread runs before it is entered")
    _limit(memory_limit)
    if ctypes.CDLL(None).prctl(NO_NEW_PRIVS, 1, 0, 0, 0):
        raise _refused("no_new_privs")
    _drop_capabilities()
    _restrict_files(folder, readable)
    told = {"read": [str(p.resolve()) for p in readable], "write": str(folder)}
    told["devices"] = list(DEVICES)
    listener = _watch_calls()
    try:
        socket.send_fds(guard, [json.dumps(told).encode()], [listener])
    finally:
        os.close(listener)
        guard.close()


def _readable() -> list[Path]:
    python = [sys.prefix, sys.base_prefix, sys.exec_prefix, str(HOME)]
    python += [*sysconfig.get_paths().values(), str(cache_folder())]
    python += [entry for entry in sys.path if entry.endswith("-packages")]
    return [Path(path) for path in dict.fromkeys((*SYSTEM, *DEVICES, *python))]


def _limit(memory: float | None) -> None:
    if memory is None:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        taken = pages * resource.getpagesize()
        _lower(resource.RLIMIT_AS, taken + int(MEMORY))
    _lower(resource.RLIMIT_FSIZE, LARGEST_FILE)
    _lower(resource.RLIMIT_NOFILE, MOST_FILES)
    _lower(resource.RLIMIT_CORE, 0)


def _lower(what: int, limit: int) -> None:
    _, hard = resource.getrlimit(what)
    least = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(what, (least, least))


def _drop_capabilities() -> None:
    head = ctypes.create_string_buffer(struct.pack("Ii", 0x20080522, 0), 8)
    if _syscall(CAPSET[machine()], head, ctypes.create_string_buffer(24)):
        raise _refused("capset")


def _restrict_files(folder: Path, readable: Sequence[Path]) -> None:
    version = _syscall(CREATE_RULESET, None, 0, 1)
    rights = sum(new for since, new in RIGHTS.items() if since <= version)
    attributes = struct.pack("Q", rights)
    if version >= 4:
        attributes += struct.pack("Q", 3)  # to bind and to connect
    if version >= 6:
        attributes += struct.pack("Q", 3)  # abstract sockets, signals
    rules = _syscall(CREATE_RULESET, attributes, len(attributes), 0)
    if rules < 0:
        raise _refused("landlock")
    allowed = [(path, READ) for path in readable]
    allowed += [(folder, rights & ~1), (Path("/dev/null"), 2 | 4)]
    for path, granted in allowed:
        descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
        granted &= rights & (-1 if path.is_dir() else OF_FILES)
        rule = struct.pack("=Qi", granted, descriptor)
        failed = _syscall(ADD_RULE, rules, 1, ctypes.create_string_buffer(rule), 0)
        os.close(descriptor)
        if failed:
            raise _refused(f"landlock of {path}")
    if _syscall(RESTRICT_SELF, rules, 0):
        raise _refused("landlock")
    os.close(rules)


def _watch_calls() -> int:
    """Let a filter hand the watched calls to who holds the descriptor returned."""
    lines = b"".join(struct.pack("HBBI", *line) for line in _filter(os.getpid()))
    code = ctypes.create_string_buffer(lines, len(lines))
    program = struct.pack("HxxxxxxP", len(lines) // 8, ctypes.addressof(code))
    filter_ = ctypes.create_string_buffer(program)
    listener = _syscall(SECCOMP[machine()], 1, 8, filter_)  # SET_MODE_FILTER, LISTENER
    if listener < 0:
        raise _refused("seccomp")
    return listener


def _filter(own: int) -> list[tuple[int, int, int, int]]:
    """Return the filter: (code, jump if true, jump if false, operand)."""
    lines = [(LOAD, 0, 0, ARCH), (EQUAL, 1, 0, AUDIT_ARCH[machine()])]
    lines += [(RETURN, 0, 0, KILL), (LOAD, 0, 0, NUMBER)]
    if machine() == "x86_64":
        lines += [(AT_LEAST, 0, 1, X32), (RETURN, 0, 0, KILL)]
    lines += [(EQUAL, 0, 1, CLONE3), (RETURN, 0, 0, ERRNO | ENOSYS)]
    for number, (_, kind) in numbers().items():
        if kind in ("clone", "signal"):
            test = (ANY_BIT, CLONE_THREAD) if kind == "clone" else (EQUAL, own)
            lines += [(EQUAL, 0, 4, number), (LOAD, 0, 0, FIRST)]
            lines += [(test[0], 0, 1, test[1]), (RETURN, 0, 0, ALLOW)]
        else:
            lines += [(EQUAL, 0, 1, number)]
        lines += [(RETURN, 0, 0, NOTIFY)]
    return [*lines, (RETURN, 0, 0, ALLOW)]


def _syscall(number: int, *arguments: Any) -> int:
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    given = [ctypes.c_long(a) if isinstance(a, int) else a for a in arguments]
    return int(libc.syscall(ctypes.c_long(number), *given))


def _refused(what: str) -> SimulationError:
    why = os.strerror(ctypes.get_errno())
    return SimulationError(f"sandbox: the kernel refuses {what} ({why})")
