"""Calls to Linux that a sandbox watches: their numbers on x86_64 and aarch64, the class
of each, and the places of its arguments.

``WATCHED[name]`` is (x86_64, aarch64, kind), None for a call that there is not.
"""

import platform
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["denied", "signal", "clone", "open", "openat", "at", "plain"]

AUDIT_ARCH = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
X32 = 0x40000000  # numbers of another interface of x86_64
CLONE3 = 435

# denied: whatever its arguments; signal: but to itself; clone: but a thread;
# open, openat: by path and flags; at, plain: paths that are written to
WATCHED: dict[str, tuple[int | None, int | None, Kind]] = {
    "execve": (59, 221, "denied"),
    "execveat": (322, 281, "denied"),
    "fork": (57, None, "denied"),
    "vfork": (58, None, "denied"),
    "clone": (56, 220, "clone"),
    "socket": (41, 198, "denied"),
    "socketpair": (53, 199, "denied"),
    "connect": (42, 203, "denied"),
    "bind": (49, 200, "denied"),
    "ptrace": (101, 117, "denied"),
    "process_vm_readv": (310, 270, "denied"),
    "process_vm_writev": (311, 271, "denied"),
    "kill": (62, 129, "signal"),
    "tgkill": (234, 131, "signal"),
    "rt_sigqueueinfo": (129, 138, "signal"),
    "rt_tgsigqueueinfo": (297, 240, "signal"),
    "tkill": (200, 130, "denied"),
    "pidfd_open": (434, 434, "denied"),
    "pidfd_send_signal": (424, 424, "denied"),
    "pidfd_getfd": (438, 438, "denied"),
    "open": (2, None, "open"),
    "creat": (85, None, "plain"),
    "openat": (257, 56, "openat"),
    "openat2": (437, 437, "openat"),
    "open_by_handle_at": (304, 265, "denied"),
    "truncate": (76, 45, "plain"),
    "unlink": (87, None, "plain"),
    "unlinkat": (263, 35, "at"),
    "rename": (82, None, "plain"),
    "renameat": (264, 38, "at"),
    "renameat2": (316, 276, "at"),
    "mkdir": (83, None, "plain"),
    "mkdirat": (258, 34, "at"),
    "rmdir": (84, None, "plain"),
    "mknod": (133, None, "denied"),
    "mknodat": (259, 33, "denied"),
    "link": (86, None, "denied"),
    "linkat": (265, 37, "denied"),
    "symlink": (88, None, "denied"),
    "symlinkat": (266, 36, "denied"),
    "chmod": (90, None, "denied"),
    "fchmod": (91, 52, "denied"),
    "fchmodat": (268, 53, "denied"),
    "fchmodat2": (452, 452, "denied"),
    "chown": (92, None, "denied"),
    "fchown": (93, 55, "denied"),
    "lchown": (94, None, "denied"),
    "fchownat": (260, 54, "denied"),
    "utime": (132, None, "denied"),
    "utimes": (235, None, "denied"),
    "utimensat": (280, 88, "denied"),
    "futimesat": (261, None, "denied"),
    "setxattr": (188, 5, "denied"),
    "lsetxattr": (189, 6, "denied"),
    "fsetxattr": (190, 7, "denied"),
    "mount": (165, 40, "denied"),
    "umount2": (166, 39, "denied"),
    "move_mount": (429, 429, "denied"),
    "open_tree": (428, 428, "denied"),
    "fsopen": (430, 430, "denied"),
    "mount_setattr": (442, 442, "denied"),
    "unshare": (272, 97, "denied"),
    "setns": (308, 268, "denied"),
    "chroot": (161, 51, "denied"),
    "pivot_root": (155, 41, "denied"),
    "bpf": (321, 280, "denied"),
    "perf_event_open": (298, 241, "denied"),
    "io_uring_setup": (425, 425, "denied"),
    "userfaultfd": (323, 282, "denied"),
    "keyctl": (250, 219, "denied"),
    "add_key": (248, 217, "denied"),
    "init_module": (175, 105, "denied"),
    "finit_module": (313, 273, "denied"),
    "kexec_load": (246, 104, "denied"),
    "reboot": (169, 142, "denied"),
}
WRITES_TWO = {"rename": (0, 1), "renameat": (1, 3), "renameat2": (1, 3)}


def machine() -> str:
    """Return the machine as AUDIT_ARCH names it."""
    return platform.machine().replace("arm64", "aarch64").replace("AMD64", "x86_64")


def numbers() -> dict[int, tuple[str, Kind]]:
    """Return name and kind of every watched call by its number on this machine."""
    place = list(AUDIT_ARCH).index(machine())
    return {
        number: (name, kind)
        for name, (*both, kind) in WATCHED.items()
        if (number := both[place]) is not None
    }
