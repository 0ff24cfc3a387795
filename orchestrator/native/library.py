"""The compiled kernel and its structures, as kernel.h and channel.c declare them.

Compiled once per digest of its source with the compiler and the flags of the
FMUs, and kept in their cache.
"""

import ctypes
from ctypes import c_double, c_int32, c_int64, c_size_t, c_uint32, c_void_p
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from fmus.cache import cache_folder
from fmus.compile import compile_alone, host_platform

SOURCES = sorted(Path(__file__).parent.glob("*.[ch]"))
CODES = ("step", "read", "copy", "release", "write", "hold", "row", "fault", "inject")
FAILURES = (
    *("", "step", "get", "set", "not finite", "does not fit", "tick", "copy"),
    "ended",
)
LAWS = ("stuck", "bias", "gain", "quantisation", "override", "delay")
DOING = ("set", "doStep", "get")  # of a channel
ASK = ("step", "exchange", "leave")
TYPES: tuple[Any, ...] = (
    c_double,
    c_int64,
    ctypes.c_uint64,
    ctypes.c_float,
    ctypes.c_int8,
    ctypes.c_uint8,
    ctypes.c_int16,
    ctypes.c_uint16,
    c_int32,
    c_uint32,
)
IN_PLACE = TYPES[:3]  # of 8 bytes, kept in the vector as they are
BOOLEANS = {2: len(TYPES), 3: len(TYPES) + 1}  # by FMI version


class Group(ctypes.Structure):
    """Variables of one type."""

    _fields_: ClassVar[Any] = [
        ("get", c_void_p),
        ("set", c_void_p),
        ("references", c_void_p),
        ("n_references", c_size_t),
        ("size", c_size_t),
        ("values", c_void_p),
        ("buffer", c_void_p),
        ("low", c_double),
        ("high", c_double),
        ("type", c_int32),
        ("major", c_int32),
    ]


class Copy(ctypes.Structure):
    """One number carried from an output to an input."""

    _fields_: ClassVar[Any] = [
        ("sink", c_void_p),
        ("source", c_void_p),
        ("gain", c_double),
        ("offset", c_double),
        ("from_", c_int32),
        ("to", c_int32),
        ("law", c_int32),
        ("low", c_double),
        ("high", c_double),
    ]


class Span(ctypes.Structure):
    """Values read that are doubles."""

    _fields_: ClassVar[Any] = [("first", c_size_t), ("end", c_size_t)]


class Outcome(ctypes.Structure):
    """How the latest step of an FMU ended."""

    _fields_: ClassVar[Any] = [
        ("reached", c_double),
        ("ended", c_int32),
        ("early", c_int32),
        ("last", c_int32),
    ]


class Ticker(ctypes.Structure):
    """What ticks an FMU by its clock."""

    _fields_: ClassVar[Any] = [
        ("set_clock", c_void_p),
        ("update", c_void_p),
        ("enter_step", c_void_p),
        ("enter_event", c_void_p),
        ("reference", c_uint32),
    ]


class Part(ctypes.Structure):
    """One FMU instance and its places in the vector."""

    _fields_: ClassVar[Any] = [
        ("instance", c_void_p),
        ("do_step", c_void_p),
        ("clock", c_void_p),
        ("inputs", c_void_p),
        ("outputs", c_void_p),
        ("n_inputs", c_size_t),
        ("n_outputs", c_size_t),
        ("copies", c_void_p),
        ("n_copies", c_size_t),
        ("n_exact", c_size_t),
        ("n_doubles", c_size_t),
        ("raw", c_void_p),
        ("published", c_void_p),
        ("n_read", c_size_t),
        ("n_delayed", c_size_t),
        ("spans", c_void_p),
        ("n_spans", c_size_t),
        ("line", c_void_p),
        ("latency", c_size_t),
        ("head", c_size_t),
        ("major", c_int32),
        ("steps", c_int64),
        ("readings", c_int64),
        ("spent", c_double),
        ("outcome", c_void_p),
        ("ticker", c_void_p),
        ("pending", c_int32),
        ("h", c_double),
    ]


class Table(ctypes.Structure):
    """Rows of one period."""

    _fields_: ClassVar[Any] = [
        ("time", c_void_p),
        ("columns", c_void_p),
        ("sources", c_void_p),
        ("n_columns", c_size_t),
        ("capacity", c_int64),
        ("count", c_void_p),
    ]


class Op(ctypes.Structure):
    """One operation."""

    _fields_: ClassVar[Any] = [
        ("code", c_int32),
        ("target", c_int32),
        ("back", c_int64),
        ("h", c_double),
    ]


class Program(ctypes.Structure):
    """The operations of one instant."""

    _fields_: ClassVar[Any] = [("ops", c_void_p), ("n", c_size_t)]


class Injection(ctypes.Structure):
    """Values added to an input."""

    _fields_: ClassVar[Any] = [
        ("sink", c_void_p),
        ("before", c_void_p),
        ("values", c_void_p),
        ("n", c_int64),
        ("first", c_int64),
        ("every", c_int64),
    ]


class Fault(ctypes.Structure):
    """What goes wrong with a number, and what it remembers of it."""

    _fields_: ClassVar[Any] = [
        ("kind", c_int32),
        ("samples", c_int32),
        ("start", c_int64),
        ("end", c_int64),
        ("value", c_double),
        ("memory", c_void_p),
    ]


@cache
def faulty_structure(lanes: int) -> Any:
    """Return the structure of a number that has faults, for W lanes."""

    class Faulty(ctypes.Structure):
        _fields_: ClassVar[Any] = [
            ("clean", c_double if lanes == 1 else c_double * lanes),
            ("place", c_void_p),
            ("faults", c_void_p),
            ("n", c_int32),
            ("source", c_int32),
            ("converts", c_int32),
            ("_", c_int32),
            ("gain", c_double),
            ("offset", c_double),
            ("back_gain", c_double),
            ("back_offset", c_double),
            *padding(8 * lanes + 64, lanes),
        ]

    return Faulty


def padding(size: int, lanes: int, name: str = "after") -> list[tuple[str, Any]]:
    """Return the field that fills up to a multiple of a vector's size, if any is."""
    missing = -size % (8 * lanes)
    return [(name, ctypes.c_char * missing)] if missing else []


class Kernel(ctypes.Structure):
    """All of it, and how the latest call ended."""

    _fields_: ClassVar[Any] = [
        ("parts", c_void_p),
        ("tables", c_void_p),
        ("programs", c_void_p),
        ("tick_num", c_int64),
        ("tick_den", c_int64),
        ("profiled", c_int32),
        ("full", c_int32),
        ("ending", c_int32),
        ("failure", c_int32),
        ("status", c_int32),
        ("instant", c_int64),
        ("part", c_int32),
        ("group", c_int32),
        ("h", c_double),
        ("readings", c_int64),
        ("spent", c_double),
        ("noted", c_void_p),
        ("injections", c_void_p),
        ("faulty", c_void_p),
        ("n_faulty", c_size_t),
    ]


class Stretch(ctypes.Structure):
    """Instants that repeat."""

    _fields_: ClassVar[Any] = [
        ("first", c_int64),
        ("length", c_int64),
        ("offsets", c_void_p),
        ("programs", c_void_p),
        ("n", c_size_t),
    ]


class Turn(ctypes.Structure):
    """A number that one process sets and another waits for."""

    _fields_: ClassVar[Any] = [
        ("number", c_uint32),
        ("slept_on", c_uint32),
        ("_", ctypes.c_char * 56),
    ]


class Channel(ctypes.Structure):
    """What a master and the process of an FMU share besides values."""

    _fields_: ClassVar[Any] = [
        ("asked", Turn),
        ("answered", Turn),
        ("what", c_int32),
        ("given", c_int32),
        ("doing", c_int32),
        ("failed", c_int32),
        ("t", c_double),
        ("h", c_double),
        ("steps", c_int64),
        ("outcome", Outcome),
    ]


class Link(ctypes.Structure):
    """The master's end of a channel."""

    _fields_: ClassVar[Any] = [
        ("channel", c_void_p),
        ("values", c_void_p),
        ("n_inputs", c_size_t),
        ("n_outputs", c_size_t),
        ("within", c_double),
        ("stale", c_int32),
        ("ended", c_int32),
        ("habits", c_int32 * 4),
    ]


@cache
def library() -> Any:
    """Return the kernel, loaded; compiled first if it was not yet.

    Raises:
        CompileError: there is no compiler, or none for this platform.
    """
    sources = {file.name: file.read_text(encoding="utf-8") for file in SOURCES}
    file = compile_alone(
        "kernel", sources, host_platform(), cache_folder() / "libraries"
    )
    loaded = ctypes.CDLL(str(file))
    loaded.kernel_run.restype = c_int64
    loaded.kernel_run.argtypes = [
        ctypes.POINTER(Kernel),
        ctypes.POINTER(Stretch),
        c_int64,
        c_int64,
    ]
    loaded.kernel_begin.argtypes = [ctypes.POINTER(Kernel)]
    loaded.kernel_reading.restype = c_double
    loaded.kernel_reading.argtypes = []
    loaded.channel_serve.argtypes = [c_void_p, ctypes.POINTER(Kernel)]
    loaded.channel_answer.argtypes = [c_void_p]
    loaded.channel_ask.argtypes = [c_void_p, c_int32]
    loaded.channel_step.argtypes = [c_void_p, c_double, c_double, c_int32]
    return loaded


def address(function: Any) -> int | None:
    """Return where a function begins; None for none."""
    return ctypes.cast(function, c_void_p).value
