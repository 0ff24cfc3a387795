"""What the master does at every instant, as a flat list of operations.

At instant k (time t):

1. ``advance``: continuous components due, and those that a source publishes to
   strictly inside their step, are stepped to t with what they were last given
   (``iterate``: all of a group);
   where the window of a fault begins or ends, ``fault`` renews all faulty inputs;
2. ``read`` and ``copy``: outputs of the due ones are exchanged;
3. sampled components due, in running order: first every ``release`` (latency
   lines publish), then each ``write``, ``tick``, ``read``, ``copy`` or ``hold``
   (a group: ``iterate``, then ``read``, ``copy`` of each member);
   then ``write`` for the continuous components stepped at this instant;
4. ``row``: tables due are recorded; at the stop all of them.

What a component with faults on its connections copies is followed by ``fault``,
before it by ``inject`` where something is added to it; an input that nothing drives
has its ``inject`` before the ``write`` of its component, where that is due.

At instant 0 no component is advanced: initialisation has made its outputs.
Equal situations share one program; executors compile each only once.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Literal, NamedTuple

from orchestrator.master.layout import Edge, Faulty, Injected, Part, Wiring
from orchestrator.master.order import running_order
from orchestrator.master.schedule import Clock, Schedule, Stretch

Code = Literal[
    "advance",
    "iterate",
    "read",
    "copy",
    "release",
    "inject",
    "write",
    "tick",
    "hold",
    "row",
    "fault",
]


class Op(NamedTuple):
    """One operation on a component (on a table for ``row``, on an injected input,
    by its number, for ``inject``, on a group for ``iterate``).

    ``fault`` follows what its target published; without one all are renewed.

    ``back`` and ``h`` of an ``advance`` or ``iterate``: it starts ``back`` ticks before
    this instant and is ``h`` seconds long; ``h`` of a ``tick`` is the period.
    """

    code: Code
    target: str
    back: int = 0
    h: float = 0.0


Program = tuple[Op, ...]


@dataclass(frozen=True)
class Timetable:
    """A wired system's instants and programs; iterate ``instants()`` once per run."""

    wiring: Wiring

    @cached_property
    def schedule(self) -> Schedule:
        clocks = {
            n: Clock(p.component.period, p.component.offset)
            for n, p in self.wiring.parts.items()
        }
        for period in self.wiring.tables:
            clocks[table_name(period)] = Clock(period)
        once = self.wiring.system.stop + next(iter(clocks.values())).period
        clocks |= {name: Clock(once, t) for name, t in self._switches.items()}
        return Schedule.of(clocks, self.wiring.system.stop)

    @cached_property
    def order(self) -> tuple[str, ...]:
        return self._ordered[0]

    @cached_property
    def waiting(self) -> frozenset[Edge]:
        return self._ordered[1]

    @cached_property
    def _ordered(self) -> tuple[tuple[str, ...], frozenset[Edge]]:
        return running_order(self.wiring)

    @cached_property
    def continuous(self) -> tuple[Part, ...]:
        return tuple(p for p in self.wiring.parts.values() if p.kind == "continuous")

    def instants(self) -> Iterator[tuple[int, Program]]:
        """Yield each instant k and its program, in order, 0 and the stop included."""
        for stretch in self.stretches():
            yield from stretch

    def stretches(self) -> Iterator[Stretch[Program]]:
        """Yield the same, as stretches of instants of which long ones repeat."""
        bit = {name: 1 << i for i, name in enumerate(self.schedule.names)}
        wakes = [bit[p.name] | self._splitters(p, bit) for p in self.continuous]
        last = [0] * len(self.continuous)
        programs: dict[tuple[int, ...], Program] = {}

        def program(k: int, mask: int) -> Program:
            first, ending = k == 0, k == self.schedule.stop
            backs = [
                k - begun if (mask & wake or ending) and k > begun else 0
                for wake, begun in zip(wakes, last, strict=True)
            ]
            for i, back in enumerate(backs):
                if back:
                    last[i] = k
            key = (mask, first, ending, *backs)
            if key not in programs:
                programs[key] = self._program(mask, bit, backs, first, ending)
            return programs[key]

        for masks in self.schedule.stretches():
            once = tuple(program(k, mask) for k, mask in replace(masks, repeats=1))
            first, length, repeats = masks.first, masks.length, masks.repeats
            yield Stretch(first, length, repeats, masks.offsets, once)
            begun, later = first + masks.offsets[0], (repeats - 1) * length
            last[:] = [k + later if k >= begun else k for k in last]

    def steps(self) -> dict[str, int]:
        """Count the steps and ticks of every component over the run."""
        counted = dict.fromkeys(self.wiring.parts, 0)
        members = {group.name: group.members for group in self.wiring.groups}
        stepping: dict[int, list[str]] = {}
        for stretch in self.stretches():
            for program in stretch.entries:
                if id(program) not in stepping:
                    stepping[id(program)] = [
                        op.target for op in program if op.code in ("advance", "tick")
                    ]
                    stepping[id(program)] += [
                        name
                        for op in program
                        if op.code == "iterate"
                        for name in members[op.target]
                    ]
                for name in stepping[id(program)]:
                    counted[name] += stretch.repeats
        return counted

    def _splitters(self, part: Part, bit: dict[str, int]) -> int:
        """Return the mask of the clocks that split a component's steps."""
        if not part.splits:
            return 0
        wiring, group = self.wiring, self.wiring.group_of(part.name)
        members = group.members if group else (part.name,)
        splitters = {e.source for e in wiring.edges if e.sink in members}
        splitters |= {
            _switch_name(t)
            for faulty in wiring.faulty
            if faulty.edge.sink in members
            for t in switches(faulty)
        }
        return sum(bit[name] for name in splitters if name in bit)

    def _program(
        self,
        mask: int,
        bit: dict[str, int],
        backs: list[int],
        first: bool,
        ending: bool,
    ) -> Program:
        parts, ops = self.wiring.parts, list[Op]()
        every = dict(zip(self.schedule.names, self.schedule.every, strict=True))
        for part, back in zip(self.continuous, backs, strict=True):
            if back:
                full = back == every[part.name]
                h = (
                    float(part.component.period)
                    if full
                    else self.schedule.duration(back)
                )
                ops += self._stepped(Op("advance", part.name, back, h))
        if any(mask & bit[name] for name in self._switches):
            ops.append(Op("fault", ""))
        for part in self.continuous:
            if (mask & bit[part.name] or ending) and not first:
                ops += [Op("read", part.name), Op("copy", part.name)]
        ticking = [parts[name] for name in self.order if mask & bit[name]]
        ops += [Op("release", p.name) for p in ticking if p.component.latency]
        for part in ticking:
            h, group = float(part.component.period), self.wiring.group_of(part.name)
            for name in group.members if group else (part.name,):
                if group is None or part.name == group.members[0]:
                    ops += self._injections(name, driven=False)
            if group is None:
                ops.append(Op("write", part.name))
            ops += self._stepped(Op("tick", part.name, 0, h))
            ops.append(Op("read", part.name))
            ops.append(Op("hold" if part.component.latency else "copy", part.name))
        for part, back in zip(self.continuous, backs, strict=True):
            if mask & bit[part.name] and not ending:
                ops += self._injections(part.name, driven=False)
            if (back or first) and not ending:
                ops.append(Op("write", part.name))
        for period in self.wiring.tables:
            name = table_name(period)
            if mask & bit[name] or ending:
                ops.append(Op("row", name))
        done = [op for op in ops if self._does_something(op)]
        return tuple(followed for op in done for followed in self._followed(op))

    def _stepped(self, op: Op) -> list[Op]:
        """Return a step of a component, or that of its group if it is the first."""
        group = self.wiring.group_of(op.target)
        if group is None:
            return [op]
        of_all = op._replace(code="iterate", target=group.name)
        return [of_all] if op.target == group.members[0] else []

    @cached_property
    def _speakers(self) -> frozenset[str]:
        return frozenset(said.source for said in self.wiring.texts)

    @cached_property
    def _switches(self) -> dict[str, Fraction]:
        """All times at which some fault begins or ends, by the name of their clock."""
        faulty, stop = self.wiring.faulty, self.wiring.system.stop
        times = sorted({t for f in faulty for t in switches(f) if t <= stop})
        return {_switch_name(t): t for t in times}

    def _followed(self, op: Op) -> tuple[Op, ...]:
        if op.code not in ("copy", "release"):
            return (op,)
        sources = {faulty.edge.source for faulty in self.wiring.faulty}
        faults = [Op("fault", op.target)] if op.target in sources else []
        return op, *self._injections(op.target, driven=True), *faults

    def _injections(self, of: str, *, driven: bool) -> list[Op]:
        return [
            Op("inject", str(i))
            for i, place in enumerate(self.wiring.injected)
            if place.of == of and place.driven == driven
        ]

    def _does_something(self, op: Op) -> bool:
        if op.code in ("row", "fault", "inject", "iterate"):
            return True
        part = self.wiring.parts[op.target]
        if op.code == "write":
            return bool(part.inputs or part.heard)
        if op.code == "read":
            return bool(part.read)
        if op.code == "copy":
            return bool(part.copies) or op.target in self._speakers
        return True

    def publications(self, injected: Injected) -> tuple[int, int]:
        """Return the first publication of an injection and their distance (ticks)."""
        component = self.wiring.parts[injected.of].component
        tick = self.schedule.tick
        return int(component.offset / tick), int(component.period / tick)


def switches(faulty: Faulty) -> frozenset[Fraction]:
    """Return the times (s) at which a fault of an input begins or ends."""
    starts = {fault.start for fault in faulty.faults}
    return frozenset(starts | {f.end for f in faulty.faults if f.end is not None})


def _switch_name(t: Fraction) -> str:
    return f"fault at {t} s"


def table_name(period: Fraction) -> str:
    """Return the name of the table with one row every ``period`` seconds."""
    return f"every {period.numerator}/{period.denominator} s"
