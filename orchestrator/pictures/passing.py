"""Which value is taken when, and from when it stems, followed through a timetable.

The operations of the instants are carried out on the instants at which values
arose instead of on the values: what the pictures show is what the executors do.
"""

from collections import deque
from dataclasses import dataclass, field
from itertools import takewhile
from math import ceil, lcm
from typing import NamedTuple

from orchestrator.master.timetable import Timetable

MOST = 60  # instants in a picture
TIMES = 4  # how often the pattern is shown at least, where it is a single instant


class Taken(NamedTuple):
    """``sink`` takes at an instant what ``source`` made of the instant ``stems``.

    A component whose steps are split where a value is published takes it once.
    """

    source: str
    sink: str
    at: int
    stems: int


class Published(NamedTuple):
    """What a component made of ``stems`` is seen from ``at`` on."""

    component: str
    at: int
    stems: int


class Step(NamedTuple):
    """A step of a continuous component, or a tick where it begins as it ends."""

    component: str
    begins: int
    ends: int


@dataclass
class Passing:
    """What happens in the instants [first, last], in ticks.

    ``pattern`` tells how many ticks repeat; ``whole`` whether all of them are here.
    """

    first: int
    last: int
    pattern: int
    whole: bool
    steps: list[Step] = field(default_factory=list)
    published: list[Published] = field(default_factory=list)
    taken: list[Taken] = field(default_factory=list)


def passing(timetable: Timetable) -> Passing:
    """Follow values through one pattern of a timetable, once it has settled."""
    parts, shown = timetable.wiring.parts, _stretch(timetable)
    edges = dict.fromkeys((e.source, e.sink) for e in timetable.wiring.edges)
    stamp: dict[tuple[str, str], int] = {}
    last: dict[tuple[str, str], int] = {}
    members = {g.name: g.members for g in timetable.wiring.groups}
    lines = {n: deque[int]() for n, p in parts.items() if p.component.latency}

    def publish(name: str, k: int, stems: int) -> None:
        stamp.update({edge: stems for edge in edges if edge[0] == name})
        if k >= shown.first:
            shown.published.append(Published(name, k, stems))

    def take(name: str, k: int) -> None:
        for edge in edges:
            if edge[1] != name or edge not in stamp:
                continue
            again = last.get(edge) == stamp[edge] and parts[name].splits
            last[edge] = stamp[edge]
            if k >= shown.first and not again:
                shown.taken.append(Taken(*edge, k, stamp[edge]))

    instants = takewhile(lambda one: one[0] <= shown.last, timetable.instants())
    for k, program in instants:
        for code, name, back, _ in program:
            if code in ("advance", "tick", "iterate"):
                begins = k - back
                if begins >= shown.first:
                    stepped = members.get(name, (name,))
                    shown.steps += [Step(one, begins, k) for one in stepped]
            if code == "hold":
                lines[name].append(k)
            if code == "release" and len(lines[name]) >= parts[name].component.latency:
                publish(name, k, lines[name].popleft())
            continuous = name in parts and parts[name].kind == "continuous"
            if code == ("read" if continuous else "tick") and name not in lines:
                publish(name, k, k)
            if code == "write":
                take(name, k)
            if code == "iterate" and not back:  # sampled: all agree at this instant
                for one in members[name]:
                    publish(one, k, k)
                for one in members[name]:
                    take(one, k)
    return shown


def _stretch(timetable: Timetable) -> Passing:
    """Return which instants to show, without anything in them."""
    schedule, parts = timetable.schedule, timetable.wiring.parts
    every = {n: int(p.component.period / schedule.tick) for n, p in parts.items()}
    late = [
        p.component.offset / schedule.tick + (p.component.latency + 1) * every[n]
        for n, p in parts.items()
    ]
    pattern, fastest = lcm(*every.values()), min(every.values())
    length = pattern * max(1, -(-TIMES * fastest // pattern))
    whole = length <= MOST * fastest
    if not whole:
        length = MOST * fastest
    settled = ceil(max(late) / pattern) * pattern
    if settled + length > schedule.stop:
        settled = 0
    return Passing(settled, min(settled + length, schedule.stop), pattern, whole)
