"""The state of an FMU for co-simulation as bytes, which another instance of the same
FMU takes over: got, serialised, deserialised and set as FMI 2.0.4, 2.1.8, and FMI
3.0.1, 2.2.10, have it; or kept in the FMU, to come back to.  ``saving`` asks an
instance wherever it runs.
"""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from orchestrator.instances.group import good, told
from orchestrator.instances.instance import LocalInstance

LARGEST = 24 << 20  # bytes that fit into a frame
_NAMES = {
    2: ("GetFMUstate", "SerializedFMUstateSize", "SerializeFMUstate"),
    3: ("GetFMUState", "SerializedFMUStateSize", "SerializeFMUState"),
}
_BACK = {
    2: ("DeSerializeFMUstate", "SetFMUstate", "FreeFMUstate"),
    3: ("DeserializeFMUState", "SetFMUState", "FreeFMUState"),
}


def save_here(instance: LocalInstance) -> bytes:
    """Return the state of an initialised instance in this process.

    Raises:
        SimulationError: the FMU refuses, or its state is too large.
    """
    get, size_of, serialise = _NAMES[instance.description.fmi_major]
    with _state(instance) as state:
        _call(instance, get, ctypes.byref(state))
        size = ctypes.c_size_t()
        _call(instance, size_of, state, ctypes.byref(size))
        if size.value > LARGEST:
            raise instance.fail(size_of, f"returned {size.value} bytes, too many")
        buffer = ctypes.create_string_buffer(max(1, size.value))
        _call(instance, serialise, state, buffer, size)
        return buffer.raw[: size.value]


def restore_here(instance: LocalInstance, saved: bytes) -> None:
    """Bring an initialised instance in this process into a state that was saved.

    Raises:
        SimulationError: the FMU refuses.
    """
    deserialise, set_, _ = _BACK[instance.description.fmi_major]
    buffer = ctypes.create_string_buffer(saved, max(1, len(saved)))
    with _state(instance) as state:
        size = ctypes.c_size_t(len(saved))
        _call(instance, deserialise, buffer, size, ctypes.byref(state))
        _call(instance, set_, state)


def keep_here(instance: LocalInstance) -> Any:
    """Return a state, to come ``back_here`` to; steps from now on may be taken back.

    Raises:
        SimulationError: the FMU refuses.
    """
    instance.tail = (0, *instance.tail[1:])  # noSetFMUStatePriorToCurrentPoint
    state = ctypes.c_void_p()
    get, _, _ = _NAMES[instance.description.fmi_major]
    _call(instance, get, ctypes.byref(state))
    return state


def back_here(instance: LocalInstance, state: Any) -> None:
    """Bring an instance back to a state that was kept."""
    _, set_, _ = _BACK[instance.description.fmi_major]
    _call(instance, set_, state)


def drop_here(instance: LocalInstance, state: Any) -> None:
    """Free a state that was kept."""
    _, _, free = _BACK[instance.description.fmi_major]
    _call(instance, free, ctypes.byref(state))


@contextmanager
def _state(instance: LocalInstance) -> Iterator[Any]:
    """Give a place for a state, and free what stands there at the end."""
    state = ctypes.c_void_p()
    yield state
    if state:
        drop_here(instance, state)


def _call(instance: LocalInstance, name: str, *arguments: Any) -> None:
    function = instance.library[f"fmi{instance.description.fmi_major}{name}"]
    function.restype = ctypes.c_int
    sizes = [isinstance(a, ctypes.c_size_t) for a in arguments]
    kinds = [ctypes.c_size_t if size else ctypes.c_void_p for size in sizes]
    function.argtypes = [ctypes.c_void_p, *kinds]
    status = function(instance.slave, *arguments)
    if not good(status):
        instance.refused(status)
        raise instance.fail(name, f"returned {told(status)}")
