"""Memory of a fused loop: NumPy arrays that its structures point into."""

import ctypes
from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.equations import Equations
from orchestrator.master.faulty import faulty_places
from orchestrator.master.fused.library import structures
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.native.library import faulty_structure

FloatArray = NDArray[np.float64]
SHORTEST = 16  # steps of h_max / 16 fit into a delay line, as in simulation.c
LONGEST_LINE = 1 << 20


def aligned(shape: Sequence[int], kind: Any = np.float64) -> NDArray[Any]:
    """Return zeros that begin at a multiple of 128 bytes."""
    count = int(np.prod(shape, dtype=np.int64))
    size = count * np.dtype(kind).itemsize
    room = np.zeros(size + 128, dtype=np.uint8)
    first = -room.ctypes.data % 128
    whole: NDArray[Any] = room[first : first + size].view(kind).reshape(shape)
    return whole


class Memory:
    """Values of all components, rows and lines, for W lanes.

    ``values[name]`` (size + n_d, W) are those of a component of ours;
    ``vector`` (places, W); ``rows`` one array (rows, columns, W) per table.
    """

    def __init__(
        self,
        source: Source,
        lanes: int,
        vector: FloatArray,
        rows: Mapping[str, FloatArray],
        kernel: Any = None,
    ) -> None:
        instance, self._line, table, engine, injected_place = structures(lanes)
        self.lanes, self.vector = lanes, vector
        self._kept: list[Any] = [vector, rows, kernel]
        self.values = {
            name: aligned((own.equations["size"] + own.equations["n_d"], lanes))
            for name, own in source.own.items()
        }
        self._parts = self._array(instance, len(source.parts))
        for own in source.own.values():
            part = self._parts[own.index]
            n = max(1, own.part.component.latency * own.part.delayed)
            part.values = self.values[own.part.name].ctypes.data
            part.held = self._zeros((n, lanes))
        tick = source.timetable.schedule.tick
        faulty = faulty_places(
            source.wiring,
            tick,
            int(vector.ctypes.data),
            lambda n: self._zeros((n, lanes)),
            self._filled,
            lanes,
        )
        faults = self._filled(faulty_structure(lanes), list(faulty))
        self._injections = self._array(injected_place, len(source.wiring.injected))
        for i, injected in enumerate(source.wiring.injected):
            values = np.array(injected.values)
            self._kept.append(values)
            self._injections[i].values = values.ctypes.data
            self._injections[i].n = len(values)
            first, every = source.timetable.publications(injected)
            self._injections[i].first, self._injections[i].every = first, every
        self.rows = self._array(table, len(source.tables))
        for name, i in source.tables.items():
            if name in rows:
                self.rows[i].values = rows[name].ctypes.data
        self.engine = self._array(engine, 1)[0]
        self.engine.vector = vector.ctypes.data
        self.engine.parts = ctypes.addressof(self._parts)
        self.engine.faults = ctypes.addressof(faults)
        self.engine.injections = ctypes.addressof(self._injections)
        self.engine.rows = ctypes.addressof(self.rows)
        if kernel is not None:
            self.engine.kernel = ctypes.addressof(kernel)
        self.engine.tick_num, self.engine.tick_den = tick.numerator, tick.denominator
        self.engine.alive = (
            1.0 if lanes == 1 else (ctypes.c_double * lanes)(*[1.0] * lanes)
        )

    def make_lines(self, own: Own) -> None:
        """Make room for a component's dead times, once its values are known."""
        equations = own.equations
        if not equations.delays:
            return
        lines = self._array(self._line, len(equations.delays))
        values = self.values[own.part.name]
        for line, delay in zip(lines, equations.delays, strict=True):
            room = capacity(equations, delay, float(values[delay[1], 0]))
            line.values = self._zeros((room, self.lanes))
            line.times = self._zeros((room,))
            line.capacity = room
        self._parts[own.index].lines = ctypes.addressof(lines)

    def part(self, own: Own) -> Any:
        """Return a component's structure."""
        return self._parts[own.index]

    def _array(self, kind: Any, n: int) -> Any:
        whole = kind * max(1, n)
        room = aligned((ctypes.sizeof(whole),), np.uint8)
        self._kept.append(room)
        return whole.from_address(room.ctypes.data)

    def _filled(self, kind: Any, elements: Sequence[Any]) -> Any:
        array = self._array(kind, len(elements))
        array[: len(elements)] = list(elements)
        return array

    def _zeros(self, shape: Sequence[int]) -> int:
        array = aligned(shape)
        self._kept.append(array)
        return int(array.ctypes.data)


def capacity(equations: Equations, delay: tuple[int, int, int], tau: float) -> int:
    """Return how many changes a delay line has room for at a dead time (s)."""
    wanted = ceil(tau / equations.numbers["h_max"] * SHORTEST) + 2
    return max(delay[2], min(max(wanted, 2), LONGEST_LINE))
