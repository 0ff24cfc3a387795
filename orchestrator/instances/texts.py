"""String and Binary variables of an instance: set before a run and read back.

Texts are UTF-8.  What an FMU returns is copied at once: its memory holds until the
next call only.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

from orchestrator.fmu.description import FmuVariable
from orchestrator.instances.group import STATUS, WARNING, Owner


class Texts:
    """One variable of texts or bytes, with the calls of ``Group``."""

    def __init__(self, instance: Owner, variables: Sequence[FmuVariable]) -> None:
        (variable,) = variables
        self._instance, self._variable = instance, variable
        self._binary = variable.sort == "binary"
        self._reference = (ctypes.c_uint * 1)(variable.reference)

    def set(self, values: Sequence[str | bytes]) -> None:
        """Set the FMU's variable."""
        raw = [v if isinstance(v, bytes) else v.encode() for v in values]
        kept = [ctypes.create_string_buffer(v, max(1, len(v) + 1)) for v in raw]
        pointers = (ctypes.c_void_p * len(kept))(*map(ctypes.addressof, kept))
        sizes = (ctypes.c_size_t * len(kept))(*map(len, raw))
        self._call("Set", pointers, sizes)

    def get(self) -> list[str | bytes]:
        """Return the FMU's variable."""
        n = self._variable.size
        pointers, sizes = (ctypes.c_void_p * n)(), (ctypes.c_size_t * n)()
        self._call("Get", pointers, sizes)
        if self._binary:
            pairs = zip(pointers, sizes, strict=True)
            return [ctypes.string_at(p, size) if p else b"" for p, size in pairs]
        found = (ctypes.string_at(p) if p else b"" for p in pointers)
        return [text.decode("utf-8", "replace") for text in found]

    def _call(self, verb: str, pointers: Any, sizes: Any) -> None:
        owner, major = self._instance, self._instance.description.fmi_major
        function = owner.library[f"fmi{major}{verb}{self._variable.fmi_type}"]
        function.restype = ctypes.c_int
        of_binary = [sizes] if self._binary else []
        count = [] if major == 2 else [ctypes.c_size_t(len(pointers))]
        one = ctypes.c_size_t(1)
        arguments = owner.slave, self._reference, one, *of_binary, pointers, *count
        if (status := function(*arguments)) > WARNING:
            owner.refused(status)
            call = f"{verb.lower()} {self._variable.name}"
            raise owner.fail(call, f"returned {STATUS[status]}")
