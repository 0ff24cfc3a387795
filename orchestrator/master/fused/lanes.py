"""Many runs of one structure at once, a member in each lane of a vector.

A member differs from the system in parameters and start values of its components;
programs, rates, latencies, faults and dead times are those of all.  Every member
has the bits of a run of its own.  A member that fails is named with its reason,
the others go on; members whose delayed inputs part company run one by one.
"""

import threading
from collections.abc import Iterator, Mapping, Sequence
from ctypes import byref
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FeedDriveError, SimulationError, WiringError
from orchestrator.master.fused.executor import (
    APART,
    LINE_FULL,
    fusible,
    not_finite,
)
from orchestrator.master.fused.library import load
from orchestrator.master.fused.memory import Memory, aligned
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.master.groups import refuse_unless_python
from orchestrator.master.layout import Column, Part
from orchestrator.master.member import Values, part_with
from orchestrator.master.timetable import Timetable, table_name
from orchestrator.result import Recorded, Signal

FloatArray = NDArray[np.float64]
UNSETTLED = 4
MEMORY = 1 << 30  # bytes of rows at most
Start: TypeAlias = Mapping[str, FloatArray]  # values of the components that differ


@dataclass(frozen=True)
class Member:
    """One run: its recorded signals, or why there are none.

    ``unsettled``: its initial circle, or one beside it, was not solved; run it for
    itself, which says why.
    """

    signals: Recorded = field(default_factory=lambda: Recorded({}))
    failure: FeedDriveError | None = None
    unsettled: bool = False


class Lanes:
    """Runs members of a timetable's system ``width`` at a time.

    Raises:
        SimulationError: a component cannot be in lanes; the message says which.
    """

    def __init__(
        self, timetable: Timetable, signals: frozenset[str], width: int
    ) -> None:
        self._timetable, self.width = timetable, width
        wiring = timetable.wiring
        refuse_unless_python(wiring, "lanes")
        found, whys = fusible(wiring.parts)
        if whys:
            raise SimulationError(
                "lanes: "
                + "; ".join(f"{name} {why}" for name, why in whys.items())
                + "; its members run one by one"
            )
        self._columns: dict[str, list[Column]] = {
            table_name(period): [c for c in columns if c.name in signals]
            for period, columns in wiring.tables.items()
        }
        self._periods = {table_name(period): period for period in wiring.tables}
        self._times = {
            name: _times(timetable, name) for name, of in self._columns.items() if of
        }
        size = sum(len(t) * len(self._columns[n]) for n, t in self._times.items())
        if 8 * size * width > MEMORY:
            raise SimulationError(
                f"lanes: {size:,} recorded numbers of each of {width} members do not "
                f"fit; record less often; its members run one by one"
            )
        places = {n: [c.index for c in of] for n, of in self._columns.items()}
        self._source = Source(timetable, found, places)
        self._text = self._source.text()
        self._kept = threading.local()
        self._base = {n: _base(own, own.part) for n, own in self._source.own.items()}

    def run(self, members: Sequence[Values]) -> Iterator[Member]:
        """Yield every member's signals or failure, in order."""
        held: list[Start] = []
        for member in members:
            try:
                start = self._start(member)
            except WiringError as error:
                yield from self._run(held, self.width)
                yield Member(failure=error)
                held = []
                continue
            full = len(held) == self.width
            if held and (full or self._dead_times(start) != self._dead_times(held[0])):
                yield from self._run(held, self.width)
                held = []
            held.append(start)
        yield from self._run(held, self.width)

    def _start(self, member: Values) -> "Start":
        parts = self._timetable.wiring.parts
        own = self._source.own
        changed = {
            name: part_with(parts[name], given) for name, given in member.items()
        }
        start = {name: _base(own[name], part) for name, part in changed.items()}
        for tau in self._dead_times(start):
            if tau < 0:  # the FMU itself would refuse it
                raise WiringError(f"a dead time of {tau:g} s cannot be negative")
        return start

    def _dead_times(self, start: "Start") -> tuple[float, ...]:
        return tuple(
            float(start.get(name, self._base[name])[tau])
            for name, own in self._source.own.items()
            for _, tau, _ in own.equations.delays
        )

    def _run(self, group: Sequence["Start"], width: int) -> Iterator[Member]:
        if not group:
            return
        rows = self._rows(width)
        vector = aligned((max(1, self._timetable.wiring.size), width))
        memory = Memory(self._source, width, vector, rows)
        self._fill(memory, group, width)
        library = load(self._text, width)
        engine = memory.engine
        if library.engine_start(byref(engine)):
            self._all_instants(library, engine)
        if engine.failure == APART and width > 1:
            for member in group:
                yield from self._run([member], 1)
            return
        if engine.failure == UNSETTLED:
            yield from (Member(unsettled=True) for _ in group)
            return
        # every lane's side by side, in one piece: many small ones cost new pages each
        turned = {n: of.transpose(2, 1, 0).copy() for n, of in rows.items()}
        members = []
        for lane in range(len(group)):
            failure = self._failure(memory, lane, width)
            if failure is not None:
                members.append(Member(failure=failure))
            else:
                members.append(Member(self._signals(turned, lane)))
        yield from members

    def _rows(self, width: int) -> dict[str, FloatArray]:
        """Return where rows are written, kept by each thread: new pages cost time."""
        if getattr(self._kept, "width", None) != width:
            self._kept.rows = {
                n: aligned((len(t), len(self._columns[n]), width))
                for n, t in self._times.items()
            }
            self._kept.width = width
        found: dict[str, FloatArray] = self._kept.rows
        return found

    def _fill(self, memory: Memory, group: Sequence["Start"], width: int) -> None:
        for name, own in self._source.own.items():
            base, values = self._base[name], memory.values[name]
            for lane in range(width):
                start = group[min(lane, len(group) - 1)]  # the last fills up
                values[: len(base), lane] = start.get(name, base)
            memory.make_lines(own)

    def _all_instants(self, library: Any, engine: Any) -> None:
        for stretch in self._timetable.stretches():
            offsets = np.array(stretch.offsets, np.int64)
            numbers = [self._source.programs[p] for p in stretch.entries]
            programs = np.array(numbers, np.int32)
            total = len(offsets) * stretch.repeats
            done = library.engine_run(
                byref(engine),
                stretch.first,
                stretch.length,
                offsets.ctypes.data,
                programs.ctypes.data,
                len(offsets),
                0,
                total,
            )
            if done < total:
                return

    def _failure(self, memory: Memory, lane: int, width: int) -> SimulationError | None:
        engine = memory.engine
        schedule = self._timetable.schedule
        if engine.failure == LINE_FULL:
            name = self._source.parts[engine.part]
            return SimulationError(
                f"{name}: a delayed input changed too often within its dead time"
            )
        alive = engine.alive if width == 1 else engine.alive[lane]
        if alive:
            return None
        name = self._source.parts[engine.failed_part[lane]]
        t = schedule.seconds(engine.failed_at[lane])
        own = self._source.own[name]
        return not_finite(own, memory.values[name][:, lane], t)

    def _signals(self, rows: Mapping[str, FloatArray], lane: int) -> Recorded:
        tables: dict[Fraction, dict[str, Signal]] = {}
        for table, times in self._times.items():
            signals = tables.setdefault(self._periods[table], {})
            for i, column in enumerate(self._columns[table]):
                values = rows[table][lane, i]
                if column.affine.converts:
                    values = column.affine.gain * values + column.affine.offset
                signals[column.name] = Signal(
                    column.name, times, values, column.unit, column.published
                )
        return Recorded(tables)


def _base(own: Own, part: Part) -> FloatArray:
    """Return a component's values before initialisation, as its FMU would hold them."""
    values = np.array(own.equations.start[: own.equations["size"]])
    for variable, given in part.start:
        values[variable.reference : variable.reference + variable.size] = given
    return values


def _times(timetable: Timetable, table: str) -> FloatArray:
    """Return the instants (s) at which a table has rows."""
    schedule, found = timetable.schedule, []
    for stretch in timetable.stretches():
        due = [
            offset
            for offset, program in zip(stretch.offsets, stretch.entries, strict=True)
            if any(op.code == "row" and op.target == table for op in program)
        ]
        begins = stretch.first + stretch.length * np.arange(stretch.repeats)
        found.append(np.add.outer(begins, np.array(due, np.int64)).ravel())
    k = np.concatenate(found)
    tick = schedule.tick
    times: FloatArray = (k * tick.numerator) / tick.denominator
    return times
