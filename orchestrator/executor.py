"""The Python executor of a timetable: the reference, and the one for debugging.

Each program is compiled once into a list of callables that take the instant k.
Values move through one vector; every output read is checked to be finite.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import isfinite
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.faults import Faults
from orchestrator.instances.instance import Instance
from orchestrator.profile import Spent
from orchestrator.timetable import Op, Program, Timetable
from orchestrator.wiring import Copy, Part

Action = Callable[[int], None]


YIELDED = 256  # instants between two yields


class Executor:
    """Runs a timetable on initialised instances; ``rows`` records a table's row.

    ``count`` says how many instants are done.
    """

    name: Literal["kernel", "python"] = "python"

    def __init__(
        self,
        timetable: Timetable,
        instances: Mapping[str, Instance],
        vector: NDArray[np.float64],
        rows: Mapping[str, Callable[[float], None]],
        *,
        profiled: bool = False,
    ) -> None:
        self._profiled = profiled
        self.count = 0
        self._timetable = timetable
        self._seconds = timetable.schedule.seconds
        self._parts = timetable.wiring.parts
        self._instances, self._rows = instances, rows
        self._view: Any = vector.data
        self._lines = {
            name: _Line(part, self._view)
            for name, part in self._parts.items()
            if part.component.latency
        }
        names = (*self._parts, None)
        self._accounts = {name: [0, 0.0] for name in names}
        self._faults = Faults(timetable.wiring, timetable.schedule, self._view)
        self._compiled: dict[int, tuple[Program, list[Action]]] = {}

    def run(self) -> Iterator[int]:
        """Carry out all instants; yield the one reached every now and then.

        Raises:
            SimulationError: an FMU failed or gave a value that is not finite.
        """
        for k, program in self._timetable.instants():
            _, actions = self._compiled.get(id(program)) or self._compile(program)
            for action in actions:
                action(k)
            self.count += 1
            if self.count % YIELDED == 0:
                yield k

    def _compile(self, program: Program) -> tuple[Program, list[Action]]:
        actions = [self._action(op) for op in program]
        if self._profiled:
            pairs = zip(actions, program, strict=True)
            actions = [self._timed(action, op) for action, op in pairs]
        compiled = program, actions
        self._compiled[id(program)] = compiled
        return compiled

    def _timed(self, action: Action, op: Op) -> Action:
        in_fmu = op.code in ("advance", "tick", "read", "write")
        account = self._accounts[op.target if in_fmu else None]
        steps = op.code in ("advance", "tick")

        def timed(k: int) -> None:
            begun = perf_counter()
            action(k)
            account[0] += steps
            account[1] += perf_counter() - begun

        return timed

    def spent(self) -> tuple[dict[str, Spent], float]:
        """Return the time in each FMU and in the master (s), if profiled."""
        accounts = self._accounts
        spent = {name: Spent(int(n), s) for name, (n, s) in accounts.items() if name}
        return spent, accounts[None][1]

    def _action(self, op: Op) -> Action:
        seconds = self._seconds
        if op.code == "row":
            row = self._rows[op.target]
            return lambda k: row(seconds(k))
        if op.code == "fault":
            return partial(self._faults.apply, op.target)
        part, instance = self._parts[op.target], self._instances[op.target]
        if op.code in ("advance", "tick"):
            step, back, h = instance.step, op.back, op.h
            return lambda k: step(seconds(k - back), h)
        if op.code == "write":
            push = instance.push
            return lambda _k: push()
        if op.code == "read":
            return self._read(part, instance)
        copy = _copy(part.copies, self._view)
        if op.code == "copy":
            return copy
        line = self._lines[op.target]
        if op.code == "hold":
            return lambda _k: line.hold()

        def release(k: int) -> None:
            line.release()
            copy(k)

        return release

    def _read(self, part: Part, instance: Instance) -> Action:
        view, pull, seconds = self._view, instance.pull, self._seconds
        first, last = part.raw, part.raw + part.read_size

        def read(k: int) -> None:
            pull()
            if not all(map(isfinite, view[first:last])):
                raise refusal(part, view[first:last].tolist(), seconds(k))

        return read


class _Line:
    """A latency line: what is held at tick k is released at tick k + latency."""

    def __init__(self, part: Part, view: Any) -> None:
        self._view, self._delayed = view, part.delayed
        self._raw, self._published = part.raw, part.published
        self._rest = part.read_size - part.delayed
        initial = view[part.raw : part.raw + part.delayed].tolist()
        self._ring = [initial] * part.component.latency
        self._head = 0

    def release(self) -> None:
        for i, value in enumerate(self._ring[self._head], self._published):
            self._view[i] = value

    def hold(self) -> None:
        view, raw, n = self._view, self._raw, self._delayed
        self._ring[self._head] = view[raw : raw + n].tolist()
        self._head = (self._head + 1) % len(self._ring)
        for i in range(n, n + self._rest):
            view[self._published + i] = view[raw + i]


def _copy(copies: tuple[Copy, ...], view: Any) -> Action:
    exact = [(c.source, c.sink) for c in copies if not c.affine.converts]
    converting = [
        (c.source, c.sink, c.affine.gain, c.affine.offset)
        for c in copies
        if c.affine.converts
    ]

    def copy(_k: int) -> None:
        for source, sink in exact:
            view[sink] = view[source]
        for source, sink, gain, offset in converting:
            view[sink] = gain * view[source] + offset

    return copy


def refusal(part: Part, values: list[float], t: float) -> SimulationError:
    """Return the error for the first value that is not finite."""
    names = [f"{v.name}" for v in part.read for _ in range(v.size)]
    name, value = next(
        (n, v) for n, v in zip(names, values, strict=True) if not isfinite(v)
    )
    return SimulationError(
        f"{part.name} ({part.fmu.path.name}): {name} is {value} at t = {t:.9g} s; "
        f"look at its inputs just before (record them), or take smaller steps"
    )
