"""All inputs or all outputs of an FMU in a process of its own, moved in one call."""

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.group import Group


class Bundle(Group):
    """All inputs or all outputs of an isolated FMU, as the kernel calls them."""

    def __init__(
        self,
        instance: Any,
        vector: NDArray[np.float64],
        first: int,
        size: int,
        getter: Any,
        setter: Any,
    ) -> None:
        self.major, self.kind, self.element = 2, "Real", ctypes.c_double
        self.instance, self.vector, self.first, self.size = (
            instance,
            vector,
            first,
            size,
        )
        self.references = (ctypes.c_uint * 1)()
        self.buffer = (ctypes.c_double * size).from_buffer(vector.data, 8 * first)
        self.getter, self.setter = getter, setter

    def failure(self, verb: str, status: int) -> SimulationError:
        failed: SimulationError = self.instance.failed_step(0.0, status)
        return failed
