"""What the master needs of an FMU instance: one small interface, wherever it runs.

Call order: ``instantiate`` (again where the FMU is to be made anew), ``set_up`` the
experiment, ``write`` start values, ``enter_initialization``, ``bind``,
``write``/``read`` as often as needed, ``exit_initialization``, ``quiet`` unless
messages are wanted, then ``push`` (all inputs), ``step``, ``pull`` (all outputs) in
the master's order, at the end ``close``.  ``push`` and ``pull`` move one contiguous
part of the master's value vector in one call per FMI type.

Every call returns normally or raises ``SimulationError`` with the instance,
the function, and what the FMU logged.
"""

import ctypes
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.instances.group import Group
from orchestrator.native import library as c


class Instance(Protocol):
    """What the master needs of an FMU instance, wherever it runs.

    ``outcome.last`` is set by a whole step after which the FMU has ended the run;
    ``ended`` says why, as an ``Ended`` unless its process is damaged.  After ``bind``,
    the kernel calls ``do_step`` on ``slave`` in the way of FMI ``step_major``, and the
    functions of the groups in that of their own ``major``.
    """

    name: str
    description: FmuDescription
    clock: ctypes.c_double
    slave: Any
    do_step: Any
    inputs: list[Group]
    outputs: list[Group]
    outcome: c.Outcome

    @property
    def step_major(self) -> int: ...
    def ended(self) -> SimulationError: ...
    def failed_step(self, h: float, status: int) -> SimulationError: ...
    def instantiate(self) -> None: ...
    def write(self, variables: Sequence[FmuVariable], values: list[Held]) -> None: ...
    def read(self, variables: Sequence[FmuVariable]) -> list[Held]: ...
    def set_up(
        self, start: float, stop: float | None, tolerance: float | None
    ) -> None: ...
    def enter_initialization(self) -> None: ...
    def exit_initialization(self) -> None: ...
    def quiet(self) -> None: ...
    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None: ...
    def push(self) -> None: ...
    def step(self, t: float, h: float) -> None: ...
    def pull(self) -> None: ...
    def close(self) -> None: ...
