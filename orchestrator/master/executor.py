"""The Python executor of a timetable: the reference, and the one for debugging.

Each program is compiled once into a list of callables that take the instant k.
Values move through one vector; every output read is checked to be finite.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import islice
from math import isfinite
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.master.faults import Faults
from orchestrator.master.iterate import Iteration
from orchestrator.master.layout import Injected, Part
from orchestrator.master.places import Copy, Views, carry, views
from orchestrator.master.remembered import Remembered, Words
from orchestrator.master.texts import Texts
from orchestrator.master.timetable import Op, Program, Timetable
from orchestrator.profile import Spent

Action = Callable[[int], None]


YIELDED = 256  # instants between two yields


class Executor:
    """Runs a timetable on initialised instances; ``rows`` records a table's row.

    ``count`` says how many instants are done; ``run`` goes on behind them.  It yields
    as soon as the instant ``until`` is reached, if that is set.
    """

    name: Literal["kernel", "python", "fused"] = "python"

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
        self.until: int | None = None
        self._timetable = timetable
        self._seconds = timetable.schedule.seconds
        self._parts = timetable.wiring.parts
        self._instances, self._rows = instances, rows
        self._vector, self._views = vector, views(vector)
        self._bits: Any = self._views["int64"]
        self._lines = {
            name: _Line(part, self._bits)
            for name, part in self._parts.items()
            if part.component.latency
        }
        names = (*self._parts, None)
        self._accounts = {name: [0, 0.0] for name in names}
        self._faults = Faults(timetable.wiring, timetable.schedule, vector)
        self._start = {
            i.place: float(vector[i.place]) for i in timetable.wiring.injected
        }
        self._groups = {
            group.name: Iteration(group, self._parts, instances, vector)
            for group in timetable.wiring.groups
        }
        self._texts = Texts(timetable.wiring, instances)
        self._compiled: dict[int, tuple[Program, list[Action]]] = {}

    def run(self) -> Iterator[int]:
        """Carry out all instants; yield the one reached every now and then.

        Raises:
            SimulationError: an FMU failed or gave a value that is not finite.
            Ended: an FMU ended the run.
        """
        instances = list(self._instances.values())
        for k, program in islice(self._timetable.instants(), self.count, None):
            _, actions = self._compiled.get(id(program)) or self._compile(program)
            for action in actions:
                action(k)
            self.count += 1
            for instance in instances:
                if instance.outcome.last:
                    raise instance.ended()
            paused = self.until is not None and k >= self.until
            if paused or self.count % YIELDED == 0:
                yield k

    def remembered(self) -> Remembered:
        """Return what is held back and what faults remember, between two instants."""
        lines = {name: line.held() for name, line in self._lines.items()}
        return Remembered(lines, self._faults.remembered())

    def remember(self, known: Remembered) -> None:
        """Take over what another executor of the same timetable remembered."""
        for name, line in self._lines.items():
            line.take(known.lines[name])
        self._faults.remember(known.faults)

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
        if op.code == "inject":
            return self._inject(self._timetable.wiring.injected[int(op.target)])
        if op.code == "iterate":
            return self._iterate(op)
        part, instance = self._parts[op.target], self._instances[op.target]
        if op.code in ("advance", "tick"):
            step, back, h = instance.step, op.back, op.h
            return lambda k: step(seconds(k - back), h)
        if op.code == "write":
            return self._write(part, instance)
        if op.code == "read":
            return self._read(part, instance)
        copy = _copy(part.copies, self._views, seconds)
        if op.code == "copy" and self._texts.leave(part.name):
            return self._said(part.name, copy)
        if op.code == "copy":
            return copy
        line = self._lines[op.target]
        if op.code == "hold":
            return lambda _k: line.hold()

        def release(k: int) -> None:
            line.release()
            copy(k)

        return release

    def _iterate(self, op: Op) -> Action:
        run, give, seconds = (
            self._groups[op.target].run,
            self._texts.give,
            self._seconds,
        )
        groups = {group.name: group for group in self._timetable.wiring.groups}
        members = groups[op.target].members if op.back == 0 else ()
        told = [name for name in members if self._texts.reach(name)]

        def iterate(k: int) -> None:
            for name in told:
                give(name)
            run(seconds(k - op.back), op.h)

        return iterate

    def _said(self, name: str, copy: Action) -> Action:
        publish = self._texts.publish

        def say(k: int) -> None:
            copy(k)
            publish(name)

        return say

    def _write(self, part: Part, instance: Instance) -> Action:
        push, name = instance.push, part.name
        group = self._timetable.wiring.group_of(name)
        after: list[Callable[[], None]] = []
        if group is not None:
            after.append(partial(self._groups[group.name].wrote, part))
        if self._texts.reach(name):
            after.append(partial(self._texts.give, name))

        def write(_k: int) -> None:
            push()
            for further in after:
                further()

        return write if after else lambda _k: push()

    def _inject(self, injected: Injected) -> Action:
        first, every = self._timetable.publications(injected)
        view, place, values = self._views["float64"], injected.place, injected.values
        n, start = len(values), self._start[injected.place]

        def inject(k: int) -> None:
            before = view[place] if injected.driven else start
            view[place] = before + values[(k - first) // every % n]

        return inject

    def _read(self, part: Part, instance: Instance) -> Action:
        view, pull, seconds = self._views["float64"], instance.pull, self._seconds
        spans = [slice(part.raw + first, part.raw + end) for first, end in part.spans]

        def read(k: int) -> None:
            pull()
            for span in spans:
                if not all(map(isfinite, view[span])):
                    raise refusal(part, self._vector, seconds(k))

        return read


class _Line:
    """A latency line: what is held at tick k is released at tick k + latency."""

    def __init__(self, part: Part, bits: Any) -> None:
        self._bits, self._delayed = bits, part.delayed
        self._raw, self._published = part.raw, part.published
        self._rest = part.read_size - part.delayed
        initial = bits[part.raw : part.raw + part.delayed].tolist()
        self._ring = [initial] * part.component.latency
        self._head = 0

    def held(self) -> Words:
        """Return what is held back, the oldest first."""
        rows = self._ring[self._head :] + self._ring[: self._head]
        return np.array(rows, dtype=np.int64).reshape(-1)

    def take(self, held: Words) -> None:
        self._ring = held.reshape(len(self._ring), self._delayed).tolist()
        self._head = 0

    def release(self) -> None:
        for i, value in enumerate(self._ring[self._head], self._published):
            self._bits[i] = value

    def hold(self) -> None:
        bits, raw, n = self._bits, self._raw, self._delayed
        self._ring[self._head] = bits[raw : raw + n].tolist()
        self._head = (self._head + 1) % len(self._ring)
        for i in range(n, n + self._rest):
            bits[self._published + i] = bits[raw + i]


def _copy(
    copies: tuple[Copy, ...], views: Views, seconds: Callable[[int], float]
) -> Action:
    view, bits = views["float64"], views["int64"]
    exact = [(c.source, c.sink) for c in copies if c.is_exact]
    rest = [c for c in copies if not c.is_exact]
    converting = [
        (c.source, c.sink, c.affine.gain, c.affine.offset)
        for c in rest
        if c.is_of_doubles
    ]
    between_types = [c for c in rest if not c.is_of_doubles]

    def copy(k: int) -> None:
        for source, sink in exact:
            bits[sink] = bits[source]
        for source, sink, gain, offset in converting:
            view[sink] = gain * view[source] + offset
        for c in between_types:
            carry(c, views, seconds(k))

    return copy


def refusal(part: Part, vector: NDArray[np.float64], t: float) -> SimulationError:
    """Return the error for the first value that is not finite."""
    names = [f"{v.name}" for v in part.read for _ in range(v.size)]
    places = [i for first, end in part.spans for i in range(first, end)]
    found = ((names[i], float(vector[part.raw + i])) for i in places)
    name, value = next((n, v) for n, v in found if not isfinite(v))
    return SimulationError(
        f"{part.name} ({part.fmu.path.name}): {name} is {value} at t = {t:.9g} s; "
        f"look at its inputs just before (record them), or take smaller steps"
    )
