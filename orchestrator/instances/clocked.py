"""A sampled FMI 3.0 FMU ticked by its clock, in event mode.

It rests in event mode: inputs are set there, ``step`` activates the clock and
updates the discrete states, ``pull`` reads the outputs of the tick and then moves
the FMU on, by doStep, into event mode at the next tick.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuVariable
from orchestrator.instances.doing import mark
from orchestrator.instances.ending import Ended
from orchestrator.instances.group import DISCARD, OK, good, told
from orchestrator.instances.instance import LocalInstance
from orchestrator.native import library as c

UPDATES = 100  # of one event


class ClockedInstance(LocalInstance):
    """As ``LocalInstance``, for FMUs with a periodic input clock."""

    def _create(self) -> None:
        self._fmu.instantiate(
            logMessage=self._fmi3_message, loggingOn=True, eventModeUsed=True
        )

    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None:
        super().bind(vector, inputs, first_input, outputs, first_output)
        assert self.description.clock is not None
        self.clock_reference = ctypes.c_uint(self.description.clock)
        self.set_clock = self._function("fmi3SetClock", 4)
        self.update = self._function("fmi3UpdateDiscreteStates", 7)
        self.enter_step = self._function("fmi3EnterStepMode", 1)
        self.enter_event = self._function("fmi3EnterEventMode", 1)
        self._pending: tuple[float, float] | None = None

    def ticker(self) -> c.Ticker:
        """Return how the kernel ticks it, once it is bound."""
        return c.Ticker(
            set_clock=c.address(self.set_clock),
            update=c.address(self.update),
            enter_step=c.address(self.enter_step),
            enter_event=c.address(self.enter_event),
            reference=self.clock_reference.value,
        )

    def _function(self, name: str, count: int) -> Any:
        pointers: list[Any] = [ctypes.c_void_p] * count
        if count == 4:
            pointers[2] = ctypes.c_size_t
        prototype = ctypes.CFUNCTYPE(ctypes.c_int, *pointers)
        return prototype((name, self.library))

    def step(self, t: float, h: float) -> None:
        mark(self.name, "doStep")
        self.clock.value = t
        if status := self._tick():
            raise self.failed_tick(status)
        self._pending = t, h
        if not self.outputs:
            self._move_on()

    def pull(self) -> None:
        super().pull()
        self._move_on()

    def _tick(self) -> int:
        """Return a status above a warning, or 0."""
        reference = ctypes.byref(self.clock_reference)
        active = ctypes.byref(ctypes.c_bool(True))
        status = int(self.set_clock(self.slave, reference, 1, active))
        flags = [ctypes.c_bool() for _ in range(5)]
        again, ended = flags[:2]
        next_time = ctypes.byref(ctypes.c_double())
        pointers = [*map(ctypes.byref, flags), next_time]
        for _ in range(UPDATES):
            if not good(status):
                return status
            status = int(self.update(self.slave, *pointers))
            if ended.value or not again.value:
                break
        if not good(status):
            return status
        return DISCARD if ended.value else OK

    def _move_on(self) -> None:
        if self._pending is None:
            return
        (t, h), self._pending = self._pending, None
        status = self.enter_step(self.slave)
        if good(status):
            super().step(t, h)
            if self.outcome.last:
                return
            status = self.enter_event(self.slave)
        if not good(status):
            raise self.failed_step(h, status)

    def failed_tick(self, status: int) -> SimulationError:
        """Return the error for a tick that returned a status, or ended the run."""
        if status == DISCARD:  # as _tick and kernel.c say it
            reason = "an event asked to end the simulation"
            return Ended(self.name, self.time, reason)
        return self.fail("the tick of its clock", f"returned {told(status)}")
