"""A fused loop compiled and loaded, and its structures as engine.h declares them."""

import ctypes
import platform
from ctypes import c_double, c_int32, c_int64, c_size_t, c_void_p
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from fmus.cache import cache_folder
from fmus.compile import compile_alone, host_platform
from fmus.native_source import adapter_sources
from orchestrator.native import library as kernel

HEADERS = Path(kernel.__file__).parent / "fused"
FAULTS = HEADERS.parent / "faults.h"
ELEMENTARY = ("elementary.h", "angles.h", "sums.h")
QUIET = (
    "-Wno-unused-function",
    "-Wno-unused-but-set-variable",
    "-Wno-pass-failed",
    "-Wno-macro-redefined",
)


@cache
def structures(lanes: int) -> tuple[Any, Any, Any, Any, Any]:
    """Return what engine.h declares, for W lanes, as C lays it out.

    In this order: Instance, Line, Rows, Engine, Injected.

    Vectors stand at multiples of their own size.
    """
    number = c_double if lanes == 1 else c_double * lanes

    class Line(ctypes.Structure):
        _fields_: ClassVar[Any] = [
            ("value", number),
            ("values", c_void_p),
            ("times", c_void_p),
            ("first", c_size_t),
            ("count", c_size_t),
            ("capacity", c_size_t),
            *kernel.padding(8 * lanes + 40, lanes),
        ]

    class Instance(ctypes.Structure):
        _fields_: ClassVar[Any] = [
            ("values", c_void_p),
            ("lines", c_void_p),
            ("held", c_void_p),
            ("head", c_size_t),
            *kernel.padding(32, lanes, "before"),
            ("wrong", number),
            ("failure", c_int32),
            ("_", c_int32),
            *kernel.padding(_whole(32, lanes) + 8 * lanes + 8, lanes),
        ]

    class Injected(ctypes.Structure):
        _fields_: ClassVar[Any] = [
            ("began", number),
            ("values", c_void_p),
            ("n", c_int64),
            ("first", c_int64),
            ("every", c_int64),
            *kernel.padding(8 * lanes + 32, lanes),
        ]

    class Rows(ctypes.Structure):
        _fields_: ClassVar[Any] = [("values", c_void_p), ("count", c_int64)]

    engine_size = _whole(64, lanes) + 8 * lanes + _even(4 * lanes) + 8 * lanes + 16

    class Engine(ctypes.Structure):
        _fields_: ClassVar[Any] = [
            ("vector", c_void_p),
            ("parts", c_void_p),
            ("faults", c_void_p),
            ("rows", c_void_p),
            ("injections", c_void_p),
            ("kernel", c_void_p),
            ("tick_num", c_int64),
            ("tick_den", c_int64),
            *kernel.padding(64, lanes, "before"),
            ("alive", number),
            ("failed_part", c_int32 * lanes),
            ("failed_at", c_int64 * lanes),
            ("failure", c_int32),
            ("part", c_int32),
            ("instant", c_int64),
            *kernel.padding(engine_size, lanes),
        ]

    return Instance, Line, Rows, Engine, Injected


def _whole(size: int, lanes: int) -> int:
    return size + -size % (8 * lanes)


def _even(size: int) -> int:
    return size + -size % 8


@cache
def load(text: str, lanes: int) -> Any:
    """Return the library of a source for W lanes; compiled first if it was not yet.

    Raises:
        CompileError: there is no compiler, or none for this platform.
    """
    sources = {"fused.c": text}
    for file in (*sorted(HEADERS.glob("*.h")), FAULTS):
        sources[file.name] = file.read_text(encoding="utf-8")
    adapters = adapter_sources()
    sources |= {name: adapters[name] for name in ELEMENTARY}
    flags = [f"-DW={lanes}", *QUIET]
    if lanes == 1:
        # KERNEL: for FMUs that stay calls; packing doubles lengthens the chain of
        # operations that a step waits for
        flags += ["-DKERNEL", "-fno-slp-vectorize"]
        for file in kernel.SOURCES:
            name = "kernel.c.h" if file.name == "kernel.c" else file.name
            if file.suffix == ".h" or file.name == "kernel.c":
                sources[name] = file.read_text(encoding="utf-8")
    else:
        flags += ["-mcpu=native", f"-DHOST_{processor()}"]
    built = compile_alone(
        "fused", sources, host_platform(), cache_folder() / "fused", flags=flags
    )
    loaded = ctypes.CDLL(str(built))
    engine = ctypes.POINTER(structures(lanes)[3])
    loaded.engine_run.restype = c_int64
    loaded.engine_run.argtypes = [
        engine,
        c_int64,
        c_int64,
        c_void_p,
        c_void_p,
        c_int64,
        c_int64,
        c_int64,
    ]
    loaded.engine_adopt.argtypes = [engine]
    loaded.engine_size.restype = c_size_t
    assert loaded.engine_size() == ctypes.sizeof(structures(lanes)[3])
    return loaded


@cache
def processor() -> str:
    """Return a name of this processor's instructions, for the cache."""
    from hashlib import sha256

    said = platform.processor() + platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        flags = [
            line
            for line in info.read_text().splitlines()
            if line.startswith(("flags", "model name", "Features"))
        ]
        said += "".join(sorted(set(flags)))
    return sha256(said.encode()).hexdigest()[:12]
