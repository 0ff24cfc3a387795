"""The native executor of a timetable, bit-equal to ``executor.Executor``.

Everything kernel.c works on is made here, once: parts, groups, copies, tables,
and each program the first time it is met.  The kernel is called for chunks of
instants that take about ``CHUNK_S``, so that between two of them Python can
report, write rows, and be interrupted.
"""

from collections.abc import Iterator, Mapping, Sequence
from ctypes import addressof, c_void_p, sizeof
from time import perf_counter
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.whole import Whole
from orchestrator.instances.clocked import ClockedInstance
from orchestrator.instances.doing import place
from orchestrator.instances.group import group_table
from orchestrator.instances.protocol import Instance
from orchestrator.master.executor import refusal
from orchestrator.master.faulty import faulty_places, memories
from orchestrator.master.groups import refuse_unless_python
from orchestrator.master.layout import Injected, Part
from orchestrator.master.places import Copy, carry, views
from orchestrator.master.recorder import CHUNK, Table
from orchestrator.master.remembered import Remembered, words
from orchestrator.master.schedule import Stretch
from orchestrator.master.timetable import Op, Program, Timetable
from orchestrator.native import library as c
from orchestrator.profile import Spent
from orchestrator.system import Range

CHUNK_S = 0.05
ARENA = 1 << 16  # bytes; what is used together lies together
FIRST = 64  # instants in the first chunk

Vector = NDArray[np.float64]
_CODES = {name: i for i, name in enumerate(c.CODES)}
_CODES |= {"advance": _CODES["step"], "tick": _CODES["step"]}


_TYPES = {"float64": 0, "int64": 1, "uint64": 2}  # as kernel.c numbers them


def _law(copy: Copy) -> tuple[int, float, float]:
    """Return how a copy keeps whole numbers in a range, as kernel.h numbers it."""
    whole = copy.whole
    if whole is None:
        return 0, 0.0, 0.0
    assert isinstance(whole, Whole)  # tables are refused
    return 1 + get_args(Range).index(whole.law), whole.low, whole.high


def _sorted(copies: Sequence[Copy]) -> list[Copy]:
    """Return copies as the kernel takes them: same bits, doubles, the rest."""
    return sorted(copies, key=lambda copy: (not copy.is_exact, not copy.is_of_doubles))


class Kernel:
    """Runs a timetable on initialised instances; ``count`` instants are done.

    ``run`` goes on behind them, and yields when ``until`` is reached if it is set.
    """

    name: Literal["kernel", "python", "fused"] = "kernel"

    def __init__(
        self,
        timetable: Timetable,
        instances: Mapping[str, Instance],
        vector: Vector,
        tables: Mapping[str, Table],
        *,
        profiled: bool = False,
    ) -> None:
        refuse_unless_python(timetable.wiring, f"executor {self.name}")
        self._library = c.library()
        self.count = 0
        self.until: int | None = None
        self._lines: dict[str, Vector] = {}
        self._timetable, self._vector, self._tables = timetable, vector, tables
        self._instances = instances
        self._kept: list[Any] = []
        self._arena, self._free = bytearray(), 0
        parts = timetable.wiring.parts
        self._parts = self._array(
            c.Part, [self._part(p, instances[name]) for name, p in parts.items()]
        )
        self._rows = self._array(c.Table, [self._table(t) for t in tables.values()])
        self._target = {name: i for i, name in enumerate(parts)}
        self._target_row = {name: i for i, name in enumerate(tables)}
        self._programs: list[c.Program] = []
        self._known: dict[int, tuple[int, Program]] = {}
        tick = timetable.schedule.tick
        self._injections = self._array(
            c.Injection, [self._injection(i) for i in timetable.wiring.injected]
        )
        places = self._at(0), self._numbers, self._array
        faulty = list(faulty_places(timetable.wiring, tick, *places))
        self._faulty = self._array(c.faulty_structure(1), faulty)
        self._kernel = c.Kernel(
            parts=addressof(self._parts),
            tables=addressof(self._rows),
            tick_num=tick.numerator,
            tick_den=tick.denominator,
            profiled=profiled,
            noted=place(),
            injections=addressof(self._injections),
            faulty=addressof(self._faulty),
            n_faulty=len(faulty),
        )
        self._library.kernel_begin(self._kernel)

    def run(self) -> Iterator[int]:
        """Carry out all instants; yield the one reached after every chunk.

        Raises:
            SimulationError: an FMU failed or gave a value that is not finite.
        """
        chunk, behind = FIRST, self.count
        for stretch in self._timetable.stretches():
            length = len(stretch.offsets)
            total = length * stretch.repeats
            done, behind = min(behind, total), max(0, behind - total)
            if done == total:
                continue
            compiled = self._stretch(stretch)
            while done < total:
                begun = perf_counter()
                room = min(chunk, total - done)
                if self.until is not None:
                    room = min(room, max(1, stretch.before(self.until) + 1 - done))
                n = self._library.kernel_run(self._kernel, compiled, done, room)
                took = perf_counter() - begun
                done, self.count = done + n, self.count + n
                if self._kernel.failure:
                    raise self._error()
                self._flush_full()
                if n == chunk or took > CHUNK_S:
                    chunk = max(1, min(2 * chunk, int(n * CHUNK_S / took)))
                r, i = divmod(done - 1, length)
                yield stretch.first + r * stretch.length + stretch.offsets[i]

    def remembered(self) -> Remembered:
        """Return what is held back and what faults remember, between two instants."""
        lines = {}
        for name, line in self._lines.items():
            part = self._parts[self._target[name]]
            lines[name] = np.roll(line.view(np.int64), -part.head * part.n_delayed)
        faults = memories(self._faulty, self._kernel.n_faulty)
        return Remembered(lines, np.concatenate([words([], "int64"), *faults]))

    def remember(self, known: Remembered) -> None:
        """Take over what another executor of the same timetable remembered."""
        for name, line in self._lines.items():
            line.view(np.int64)[:] = known.lines[name]
            self._parts[self._target[name]].head = 0
        rest = known.faults
        for memory in memories(self._faulty, self._kernel.n_faulty):
            memory[:], rest = rest[: len(memory)], rest[len(memory) :]

    def spent(self) -> tuple[dict[str, Spent], float]:
        """Return the time in each FMU and in the master (s), if profiled."""
        reading = self._library.kernel_reading()

        def net(of: Any) -> float:
            return max(0.0, float(of.spent) - int(of.readings) * float(reading))

        parts = zip(self._target, self._parts, strict=False)
        spent = {name: Spent(int(part.steps), net(part)) for name, part in parts}
        return spent, net(self._kernel)

    def _flush_full(self) -> None:
        if self._kernel.full:
            for table in self._tables.values():
                if table.count[0] == CHUNK:
                    table.flush()

    def _error(self) -> SimulationError:
        """Return what the Python executor would raise for the same failure."""
        kernel = self._kernel
        status, group = int(kernel.status), int(kernel.group)
        name = list(self._target)[kernel.part]
        part, instance = self._timetable.wiring.parts[name], self._instances[name]
        how = c.FAILURES[int(kernel.failure)]
        if how == "step":
            return instance.failed_step(float(kernel.h), status)
        if how == "ended":
            return instance.ended()
        if how == "tick":
            assert isinstance(instance, ClockedInstance)
            return instance.failed_tick(status)
        if how == "get":
            return instance.outputs[group].failure("get", status)
        if how == "set":
            return instance.inputs[group].failure("set", status)
        if how == "does not fit":
            sink = instance.inputs[group]
            values = self._vector[sink.first : sink.first + sink.size]
            return sink.misfit(values.tolist())
        t = self._timetable.schedule.seconds(kernel.instant)
        if how == "copy":
            try:
                carry(_sorted(part.copies)[group], views(self._vector), t)
            except SimulationError as error:
                return error
        return refusal(part, self._vector, t)

    def _at(self, place: int) -> int:
        return int(self._vector.ctypes.data) + 8 * place

    def _array(self, kind: Any, elements: Sequence[Any]) -> Any:
        """Return a C array that lives as long as this object, never empty."""
        whole = kind * max(1, len(elements))
        if self._free + sizeof(whole) > len(self._arena):
            self._arena, self._free = bytearray(max(ARENA, sizeof(whole))), 0
            self._kept.append(self._arena)
        array = whole.from_buffer(self._arena, self._free)
        self._free += -(-sizeof(whole) // 16) * 16
        array[: len(elements)] = list(elements)
        return array

    def _numbers(self, n: int) -> int:
        """Return where n numbers stand that live as long as this object."""
        self._kept.append(np.zeros(n))
        return int(self._kept[-1].ctypes.data)

    def _part(self, part: Part, instance: Instance) -> c.Part:
        inputs = [group_table(g) for g in instance.inputs]
        outputs = [group_table(g) for g in instance.outputs]
        copies = _sorted(part.copies)
        spans = self._array(c.Span, [c.Span(*span) for span in part.spans])
        line = np.tile(
            self._vector[part.raw : part.raw + part.delayed], part.component.latency
        )
        if part.component.latency:
            self._lines[part.name] = line
        self._kept.append(line)
        return c.Part(
            instance=instance.slave.value,
            do_step=c.address(instance.do_step),
            clock=addressof(instance.clock),
            inputs=addressof(self._array(c.Group, inputs)),
            n_inputs=len(inputs),
            outputs=addressof(self._array(c.Group, outputs)),
            n_outputs=len(outputs),
            copies=addressof(
                self._array(
                    c.Copy,
                    [
                        c.Copy(
                            self._at(copy.sink),
                            self._at(copy.source),
                            copy.affine.gain,
                            copy.affine.offset,
                            _TYPES[copy.from_],
                            _TYPES[copy.to],
                            *_law(copy),
                        )
                        for copy in copies
                    ],
                )
            ),
            n_copies=len(copies),
            n_exact=sum(copy.is_exact for copy in copies),
            n_doubles=sum(copy.is_exact or copy.is_of_doubles for copy in copies),
            raw=self._at(part.raw),
            published=self._at(part.published),
            n_read=part.read_size,
            n_delayed=part.delayed,
            spans=addressof(spans),
            n_spans=len(part.spans),
            line=line.ctypes.data,
            latency=part.component.latency,
            major=instance.step_major,
            outcome=addressof(instance.outcome),
            ticker=self._ticker(instance),
        )

    def _injection(self, injected: Injected) -> c.Injection:
        first, every = self._timetable.publications(injected)
        values = np.array(injected.values)
        start = self._vector[injected.place : injected.place + 1].copy()
        self._kept += [values, start]
        sink = self._at(injected.place)
        return c.Injection(
            sink=sink,
            before=sink if injected.driven else start.ctypes.data,
            values=values.ctypes.data,
            n=len(values),
            first=first,
            every=every,
        )

    def _ticker(self, instance: Instance) -> int | None:
        if not isinstance(instance, ClockedInstance):
            return None
        return addressof(self._array(c.Ticker, [instance.ticker()]))

    def _table(self, table: Table) -> c.Table:
        sources = self._array(c_void_p, [self._at(int(i)) for i in table.index])
        return c.Table(
            time=table.time.ctypes.data,
            columns=table.values.ctypes.data,
            sources=addressof(sources),
            n_columns=len(table.index),
            capacity=CHUNK,
            count=table.count.ctypes.data,
        )

    def _stretch(self, stretch: Stretch[Program]) -> c.Stretch:
        offsets = np.array(stretch.offsets, dtype=np.int64)
        known = len(self._programs)
        programs = np.array([self._program(p) for p in stretch.entries], dtype=np.int32)
        if len(self._programs) > known:
            self._all = (c.Program * len(self._programs))(*self._programs)
            self._kernel.programs = addressof(self._all)
        self._now = offsets, programs
        return c.Stretch(
            first=stretch.first,
            length=stretch.length,
            offsets=offsets.ctypes.data,
            programs=programs.ctypes.data,
            n=len(offsets),
        )

    def _program(self, program: Program) -> int:
        """Return the number of a program, compiled when it is new."""
        if id(program) not in self._known:
            ops = self._array(c.Op, [self._op(op) for op in program])
            self._known[id(program)] = len(self._programs), program
            self._programs.append(c.Program(addressof(ops), len(program)))
        return self._known[id(program)][0]

    def _op(self, op: Op) -> c.Op:
        targets = self._target_row if op.code == "row" else self._target
        if op.code == "fault":
            source = targets.get(op.target, len(targets))
            return c.Op(_CODES["fault"], source, bool(op.target))
        if op.code == "inject":
            return c.Op(_CODES["inject"], int(op.target))
        return c.Op(_CODES[op.code], targets[op.target], op.back, op.h)
