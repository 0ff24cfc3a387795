"""What the schedule does to every signal: holds, delays and ages, exactly.

The age of a signal is the time between the source's instant it stems from and
the instant the reader takes it; the hold is how long the reader then keeps it.
Both follow from the integers of the schedule, nothing is sampled or rounded.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from orchestrator.master.faults import describe
from orchestrator.master.layout import Edge, Part
from orchestrator.master.simulate import plan
from orchestrator.master.timetable import Timetable
from orchestrator.master.undriven import Undriven, undriven
from orchestrator.system import System


@dataclass(frozen=True)
class Turn:
    """When one component is due, in seconds; ``steps`` counts its steps or ticks."""

    component: str
    kind: str
    period: Fraction
    offset: Fraction
    latency: int
    steps: int


@dataclass(frozen=True)
class Age:
    """What happens to a signal on one connection; times in seconds, exact."""

    source: str
    sink: str
    published: Fraction
    read: Fraction
    youngest: Fraction
    oldest: Fraction
    remark: str


@dataclass(frozen=True)
class Plan:
    """A schedule explained; ``order`` is that of the sampled components."""

    name: str
    tick: Fraction
    stop: Fraction
    hyperperiod: Fraction
    order: tuple[str, ...]
    turns: tuple[Turn, ...]
    ages: tuple[Age, ...]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    undriven: tuple[Undriven, ...]


def describe_schedule(system: System) -> Plan:
    """Explain a system's schedule without running it.

    Raises:
        FmuError, WiringError, ScheduleError: as ``simulate`` would.
    """
    return explained(plan(system))


def explained(timetable: Timetable) -> Plan:
    """Explain a timetable."""
    system = timetable.wiring.system
    schedule, parts = timetable.schedule, timetable.wiring.parts
    steps = timetable.steps()
    turns = tuple(
        Turn(
            name,
            part.kind,
            part.component.period,
            part.component.offset,
            part.component.latency,
            steps[name],
        )
        for name, part in parts.items()
    )
    return Plan(
        system.name,
        schedule.tick,
        system.stop,
        schedule.hyperperiod * schedule.tick,
        timetable.order,
        turns,
        tuple(_age(timetable, edge) for edge in timetable.wiring.edges),
        timetable.wiring.notes,
        timetable.wiring.warnings,
        undriven(system, {name: part.fmu for name, part in parts.items()}),
    )


def _age(timetable: Timetable, edge: Edge) -> Age:
    source = timetable.wiring.parts[edge.source]
    sink = timetable.wiring.parts[edge.sink]
    split = sink.splits
    every, read = source.component.period, sink.component.period
    group = timetable.wiring.group_of(edge.source)
    iterated = group is not None and edge.sink in group.members
    if split or iterated:
        youngest = oldest = Fraction(0)
    else:
        youngest, oldest = _ages(timetable, source, sink, edge)
    delay = source.component.latency * every
    return Age(
        f"{edge.source}.{edge.output}",
        f"{edge.sink}.{edge.input}",
        every,
        min(every, read) if split else read,
        youngest + delay,
        oldest + delay,
        ", ".join(
            [
                f"iterated until both ends agree (groups.{group.name})"
                if group and iterated
                else _remark(source, sink, split, edge in timetable.waiting)
            ]
            + [
                f"fault: {describe(fault)}"
                for faulty in timetable.wiring.faulty
                if faulty.edge == edge
                for fault in faulty.faults
            ]
        ),
    )


def _ages(
    timetable: Timetable, source: Part, sink: Part, edge: Edge
) -> tuple[Fraction, Fraction]:
    """Return the least and greatest age at the sink's own instants."""
    schedule = timetable.schedule
    i, j = (schedule.names.index(p.name) for p in (source, sink))
    every, common = schedule.every[i], gcd(schedule.every[i], schedule.every[j])
    least = (schedule.first[j] - schedule.first[i]) % common
    ages = least, least + every - common
    if edge in timetable.waiting and least == 0:  # read before written: a period old
        ages = (common if common < every else every), every
    return ages[0] * schedule.tick, ages[1] * schedule.tick


def _remark(source: Part, sink: Part, split: bool, waits: bool) -> str:
    remarks = []
    if source.component.latency:
        remarks.append(f"latency {source.component.latency}")
    if waits:
        remarks.append("waits for the source's next tick: no output depends on it")
    if sink.kind == "sampled":
        if source.kind == "sampled" and not source.component.latency and not waits:
            remarks.append("same instant, source first")
        elif source.kind == "continuous":
            remarks.append("sampled")
    elif source.kind == "continuous":
        remarks.append("held over each step (Jacobi)")
    else:
        remarks.append("held (zero order)")
    if split and sink.component.period > source.component.period:
        remarks.append("steps are split where it changes")
    return ", ".join(remarks)
