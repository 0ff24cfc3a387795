"""Variables of one FMI type of one instance, moved in one call.

Bound to the master's vector, doubles and 64-bit integers are read and written there
in place; other types pass through a buffer of the FMU's own type.  What does not fit
is refused: a fraction for an integer, anything but 0 and 1 for a Boolean.
"""

import ctypes
from collections.abc import Sequence
from itertools import groupby
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.typed import bounds, fits
from orchestrator.native import library as c

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
OK, WARNING, DISCARD, ERROR, FATAL = range(5)

_FMI2 = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Boolean": "Boolean",
}
_CTYPES: dict[str, Any] = {
    "Real": ctypes.c_double,
    "Integer": ctypes.c_int32,
    "Float64": ctypes.c_double,
    "Float32": ctypes.c_float,
    "Int8": ctypes.c_int8,
    "UInt8": ctypes.c_uint8,
    "Int16": ctypes.c_int16,
    "UInt16": ctypes.c_uint16,
    "Int32": ctypes.c_int32,
    "UInt32": ctypes.c_uint32,
    "Int64": ctypes.c_int64,
    "UInt64": ctypes.c_uint64,
}


def good(status: int) -> bool:
    """Tell whether a call succeeded; a negative status is none of FMI's."""
    return OK <= status <= WARNING


def told(status: int) -> str:
    """Return a status by its name in FMI."""
    known = 0 <= status < len(STATUS)
    return STATUS[status] if known else f"{status}, which is no status of FMI"


def strict(fmu: Any) -> Any:
    """Let fmpy refuse negative statuses, which it takes for success."""
    from fmpy.fmi1 import FMICallException

    call = fmu._call

    def checked(function: str, *arguments: Any) -> Any:
        result = call(function, *arguments)
        if fmu._functions[function].restype is ctypes.c_int and result < 0:
            raise FMICallException(function=function, status=result)
        return result

    fmu._call = checked
    return fmu


class Owner(Protocol):
    """What a group asks of the instance whose variables it moves."""

    description: FmuDescription
    library: Any
    slave: Any

    def fail(self, function: str, reason: str) -> SimulationError: ...
    def failed_step(self, h: float, status: int) -> SimulationError: ...
    def refused(self, status: int) -> None: ...


class Group:
    """``names`` says which variables in messages; ``size`` counts the numbers."""

    def __init__(
        self,
        instance: Owner,
        variables: Sequence[FmuVariable],
        vector: NDArray[np.float64] | None = None,
        first: int = 0,
    ) -> None:
        kind = variables[0].fmi_type
        self.major = instance.description.fmi_major
        fmi2 = self.major == 2
        kind = _FMI2[kind] if fmi2 else _fmi3(kind)
        boolean = ctypes.c_int if fmi2 else ctypes.c_bool
        self.element: Any = boolean if kind == "Boolean" else _CTYPES[kind]
        self.instance, self.kind, self.names = instance, kind, variables[0].name
        self.size = sum(v.size for v in variables)
        references = (ctypes.c_uint * len(variables))(*(v.reference for v in variables))
        self.references = references
        self.first, self.vector = first, vector
        self.in_place = vector is not None and self.element in c.IN_PLACE
        row = self.element * self.size
        if vector is not None and self.in_place:
            self.buffer: Any = row.from_buffer(vector.data, 8 * first)
        else:
            self.buffer = row()
        sizes = [len(references)] if fmi2 else [len(references), self.size]
        before, after = sizes[:1], sizes[1:]
        self._arguments = (instance.slave, references, *before, self.buffer, *after)
        prefix = "fmi2" if fmi2 else "fmi3"
        self.getter = instance.library[f"{prefix}Get{kind}"]
        self.setter = instance.library[f"{prefix}Set{kind}"]
        for function in (self.getter, self.setter):
            function.restype = ctypes.c_int
            function.argtypes = [
                ctypes.c_void_p,
                ctypes.POINTER(ctypes.c_uint),
                ctypes.c_size_t,
                ctypes.POINTER(self.element),
                *(ctypes.c_size_t for _ in after),
            ]

    def push(self) -> None:
        """Set the FMU's variables to the values in the vector."""
        if not self.in_place:
            assert self.vector is not None
            self.fill(self.vector[self.first : self.first + self.size].tolist())
        self._call("set", self.setter)

    def pull(self) -> None:
        """Get the FMU's variables into the vector."""
        self._call("get", self.getter)
        if not self.in_place:
            assert self.vector is not None
            self.vector[self.first : self.first + self.size] = self._numbers()

    def set(self, values: Sequence[float]) -> None:
        """Set the FMU's variables to the values given."""
        self.fill(values)
        self._call("set", self.setter)

    def get(self) -> list[float]:
        """Return the FMU's variables, 64-bit integers as such."""
        self._call("get", self.getter)
        whole = self.element in (ctypes.c_int64, ctypes.c_uint64)
        return list(self.buffer) if whole else [float(v) for v in self._numbers()]

    def _numbers(self) -> list[Any]:
        """Return what is in the buffer; a Boolean that is not 0 is true."""
        found = list(self.buffer)
        return [v != 0 for v in found] if self.kind == "Boolean" else found

    def fill(self, values: Sequence[float]) -> None:
        """Put values into the buffer.

        Raises:
            SimulationError: one does not fit into the FMU's type.
        """
        if not all(map(self._fits, values)):
            raise self.misfit(values)
        fractions = self.element in (ctypes.c_double, ctypes.c_float)
        self.buffer[:] = list(values) if fractions else [int(v) for v in values]

    def _fits(self, value: float) -> bool:
        return fits(self.kind, self.major, value)

    def misfit(self, values: Sequence[float]) -> SimulationError:
        """Return the error for the first value that does not fit the type."""
        value = next(v for v in values if not self._fits(v))
        low, high = bounds(self.kind, self.major)
        kind = "number" if self.kind == "Float32" else "whole number"
        why = f"was given {value}, but takes {kind}s from {low} to {high}"
        return self.instance.fail(self._named("set"), why)

    @property
    def place(self) -> int:
        """Address of the group's values in the master's vector."""
        assert self.vector is not None
        return int(self.vector.ctypes.data) + 8 * self.first

    def failure(self, verb: str, status: int) -> SimulationError:
        """Return the error for a get or set that returned a status."""
        self.instance.refused(status)
        return self.instance.fail(self._named(verb), f"returned {told(status)}")

    def _named(self, verb: str) -> str:
        return f"{verb} {self.kind} ({self.names}, ...)"

    def _call(self, verb: str, function: Any) -> None:
        if not good(status := function(*self._arguments)):
            raise self.failure(verb, status)


def _fmi3(kind: str) -> str:
    return "Int64" if kind == "Enumeration" else kind


def groups(
    instance: Owner,
    variables: Sequence[FmuVariable],
    vector: NDArray[np.float64],
    first: int,
) -> list[Group]:
    """Return the groups of variables that lie in the vector from ``first`` on."""
    found = []
    for _, same in groupby(variables, key=lambda v: v.fmi_type):
        found.append(Group(instance, list(same), vector, first))
        first += found[-1].size
    return found


def group_table(group: Group) -> c.Group:
    """Return the kernel's view of a group, which must be kept alive."""
    major = group.major
    boolean = group.kind == "Boolean"
    low, high = bounds(group.kind, major)
    return c.Group(
        get=c.address(group.getter),
        set=c.address(group.setter),
        references=ctypes.addressof(group.references),
        n_references=len(group.references),
        size=group.size,
        values=group.place,
        buffer=ctypes.addressof(group.buffer),
        low=low,
        high=high,
        type=c.BOOLEANS[major] if boolean else c.TYPES.index(group.element),
        major=major,
    )
