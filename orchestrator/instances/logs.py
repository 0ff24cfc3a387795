"""What FMUs log: the messages, the way they come, and how it is switched off."""

import ctypes
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol
from weakref import WeakValueDictionary


@dataclass(frozen=True)
class LogMessage:
    """What an FMU logged: status, category, text, and the time it had reached."""

    status: str
    category: str
    text: str
    time: float

    def __str__(self) -> str:
        category = f", {self.category}" if self.category else ""
        return f"[{self.status}{category}] {self.text}"


class Speaker(Protocol):
    """Whoever takes the messages of an FMI 2.0 instance."""

    def record(
        self, status: int, category: bytes | None, text: bytes | None
    ) -> None: ...


SPEAKERS: WeakValueDictionary[str, Speaker] = WeakValueDictionary()


@cache
def callbacks() -> Any:
    """Return the FMI 2.0 callbacks, one set for the whole process.

    fmpy's proxy, which formats the messages, knows a single logger: the instance
    that speaks is found by its name.
    """
    from fmpy.fmi1 import calloc, free
    from fmpy.fmi2 import (
        fmi2CallbackAllocateMemoryTYPE,
        fmi2CallbackFreeMemoryTYPE,
        fmi2CallbackFunctions,
        fmi2CallbackLoggerTYPE,
    )
    from fmpy.logging import addLoggerProxy

    def message(_env: Any, name: bytes, status: int, category: Any, text: Any) -> None:
        if (speaker := SPEAKERS.get((name or b"").decode())) is not None:
            speaker.record(status, category, text)

    found = fmi2CallbackFunctions()
    found.logger = fmi2CallbackLoggerTYPE(message)
    found.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    found.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    addLoggerProxy(ctypes.byref(found))
    return found


def log_errors_only(
    library: Any, slave: Any, fmi_major: int, categories: Sequence[str]
) -> None:
    """Switch an FMU's logging off, but for the categories of errors it declares."""
    errors = [c.encode() for c in categories if _of_errors(c)]
    boolean = ctypes.c_int if fmi_major == 2 else ctypes.c_bool
    kept = (ctypes.c_char_p * len(errors))(*errors) if errors else None
    with suppress(AttributeError):  # a library may lack what every FMU must have
        function = library[f"fmi{fmi_major}SetDebugLogging"]
        function.restype = ctypes.c_int
        count = ctypes.c_size_t(len(errors))
        function(slave, boolean(bool(errors)), count, kept)


def _of_errors(category: str) -> bool:
    return any(word in category.lower() for word in ("error", "fatal"))
