"""The timetable as a picture: who steps when, what is held how long, how old it is.

A row per component.  Sampled: a mark at each tick, where values are taken, and a bar
from each publication to the next.  Continuous: a bar per step.  An arrow per link
leads from the instant a value stems from to the one at which it is taken, for the
oldest that is; the list below has the numbers.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from orchestrator.master.ages import Age, Plan, explained
from orchestrator.master.layout import Part
from orchestrator.master.timetable import Timetable
from orchestrator.pictures.passing import Passing, Published, Taken, passing
from orchestrator.pictures.svg import (
    LINE,
    arrow_heads,
    box,
    head,
    line,
    picture,
    shortened,
    text,
    width_of,
)
from orchestrator.quantities.quantity import rate

WIDTH = 980.0
ROW, BAR = 62.0, 20.0
TOP, RIGHT = 62.0, 34.0
GAP = 0.5 * (ROW - BAR)  # from a bar to where the number of its arrow stands
ASIDE = 12.0  # between arrows of one instant
APART = 44.0  # labels on the axis of time at least
UNITS = (("s", 1), ("ms", 10**3), ("us", 10**6), ("ns", 10**9))


class Linked(NamedTuple):
    """All connections between two components whose values are of one age."""

    number: int
    source: str
    sink: str
    signals: tuple[str, ...]
    age: Age


def timetable_picture(timetable: Timetable) -> str:
    """Return the timetable of a system as SVG."""
    return _Drawing(timetable).svg()


class _Drawing:
    def __init__(self, timetable: Timetable) -> None:
        self.parts = timetable.wiring.parts
        self.tick = timetable.schedule.tick
        self.plan: Plan = explained(timetable)
        self.shown: Passing = passing(timetable)
        self.links = list(_links(self.plan))
        names = [width_of(name) for name in self.parts]
        kinds = [width_of(_about(part), 11.5) for part in self.parts.values()]
        self.left = min(300.0, 24 + max([*names, *kinds]))
        self.rows = {name: TOP + ROW * i for i, name in enumerate(self.parts)}
        self.foot = TOP + ROW * len(self.parts)
        self.unit, self.factor = self._unit()

    def svg(self) -> str:
        title = f"Timetable of {', '.join(self.parts)}"
        below = [*self._list()]
        height = self.foot + 40 + LINE * (len(self.links) + 2)
        return picture(
            WIDTH,
            height,
            title,
            [
                arrow_heads("edge", "aged"),
                *self._grid(),
                *(p for name in self.parts for p in self._row(name)),
                *self._arrows(),
                *below,
            ],
        )

    def x(self, k: float) -> float:
        share = (k - self.shown.first) / max(1, self.shown.last - self.shown.first)
        return self.left + share * (WIDTH - RIGHT - self.left)

    def told(self, seconds: Fraction) -> str:
        return f"{float(seconds * self.factor):.6g}"

    def _unit(self) -> tuple[str, int]:
        """Return the unit in which the shortest period is at least 1."""
        least = min(t.period for t in self.plan.turns)
        return next((u for u in UNITS if least * u[1] >= 1), UNITS[-1])

    def _grid(self) -> Iterator[str]:
        shown = self.shown
        pattern = f"{self.told(shown.pattern * self.tick)} {self.unit}"
        said = f"everything repeats every {pattern}"
        if shown.first:
            begins = f"{self.told(shown.first * self.tick)} {self.unit}"
            said += f"; shown from t = {begins} on, when all have begun"
        if not shown.whole:
            said += "; only the first part of it is shown"
        yield text(12, 22, f"Timetable: {said}", "name")
        last = TOP + ROW * len(self.parts) - 6
        instants = sorted({s.ends for s in shown.steps} | {shown.first, shown.last})
        labels = self._labelled(instants)
        for k in instants:
            here = [(self.x(k), TOP - 8), (self.x(k), last)]
            yield line(here, "grid", 'stroke-width="1"')
            if k in labels:
                time = self.told((k - shown.first) * self.tick)
                yield text(self.x(k), TOP - 14, time, "soft small", "middle")
        yield text(self.left - 14, TOP - 14, f"time ({self.unit})", "soft small", "end")

    def _labelled(self, instants: Sequence[int]) -> set[int]:
        """Return the instants that carry a label: evenly spaced where that is so."""
        every = sorted({int(t.period / self.tick) for t in self.plan.turns})
        wide = [n for n in every if self.x(n) - self.x(0) >= APART]
        first = self.shown.first
        if wide and all(n % every[0] == 0 for n in every):
            return {k for k in instants if (k - first) % wide[0] == 0}
        chosen = [first]
        for k in instants[1:]:
            if self.x(k) - self.x(chosen[-1]) >= APART:
                chosen.append(k)
        return set(chosen)

    def _row(self, name: str) -> Iterator[str]:
        part, y = self.parts[name], self.rows[name]
        yield text(12, y + 15, shortened(name, 34), "name")
        yield text(12, y + 31, _about(part), "soft small")
        edge = [(0.0, y + ROW - 9), (WIDTH, y + ROW - 9)]
        yield line(edge, "grid", 'stroke-width="1"')
        if part.kind == "continuous":
            yield from self._steps(name, y)
        else:
            yield from self._holds(name, y)
            yield from self._ticks(name, y)

    def _steps(self, name: str, y: float) -> Iterator[str]:
        for i, step in enumerate(s for s in self.shown.steps if s.component == name):
            a, b = self.x(step.begins), self.x(step.ends)
            tip = f"{name}: step of {self.told((step.ends - step.begins) * self.tick)}"
            fill = ("step-a", "step-b")[i % 2]
            yield box(a, y, b - a, BAR, fill, "", f"{tip} {self.unit}")
        ends = {s.ends for s in self.shown.steps if s.component == name}
        seen = {p.at for p in self.shown.published if p.component == name}
        for k in sorted(ends | seen):
            down = [(self.x(k), y), (self.x(k), y + BAR)]
            width = 2.2 if k in seen else 1
            dashes = "" if k in seen else 'stroke-dasharray="3 2"'
            yield line(down, "ink", f'stroke-width="{width}" {dashes}')

    def _holds(self, name: str, y: float) -> Iterator[str]:
        seen = [p for p in self.shown.published if p.component == name]
        ends = [*(p.at for p in seen), self.shown.last][1:]
        for i, (p, end) in enumerate(zip(seen, ends, strict=True)):
            a, b = self.x(p.at), self.x(end)
            tip = f"{name}: computed at {self.told(self._since(p.stems))} {self.unit}, "
            tip += f"acts from {self.told(self._since(p.at))} {self.unit}"
            fill = ("hold-a", "hold-b")[i % 2]
            yield box(a, y, b - a, BAR, fill, "", tip)
            yield from self._latency(p, y)

    def _latency(self, p: Published, y: float) -> Iterator[str]:
        """Lead from the tick that computed a value to where it acts, if later."""
        if p.at == p.stems or p.stems < self.shown.first:
            return
        a, b = self.x(p.stems) + 2, self.x(p.at)
        low = y + BAR + 8
        path = [(a, y + BAR), (a, low), (b - 1, low), (b - 1, y + BAR + 1)]
        yield line(path, "edge", f'stroke-width="1.2" {head("edge")}')

    def _ticks(self, name: str, y: float) -> Iterator[str]:
        for step in self.shown.steps:
            if step.component == name:
                x = self.x(step.ends)
                yield line([(x, y - 4), (x, y + BAR)], "ink", 'stroke-width="2.2"')

    def _since(self, k: int) -> Fraction:
        return (k - self.shown.first) * self.tick

    def _arrows(self) -> Iterator[str]:
        used: dict[int, int] = {}
        for link in self.links:
            taken = self._oldest(link, used)
            if taken is None:
                continue
            beside = 0.0
            if taken.at == taken.stems:  # several at one instant stand side by side
                beside = ASIDE * used.get(taken.at, 0)
                used[taken.at] = used.get(taken.at, 0) + 1
            if taken.at == self.shown.last:
                beside = -beside
            a, b = self.x(taken.stems) + beside, self.x(taken.at) + beside
            down = self.rows[link.sink] > self.rows[link.source]
            y = self.rows[link.source] + (BAR if down else 0)
            end = self.rows[link.sink] + (0 if down else BAR)
            colour = "aged" if taken.at > taken.stems else "edge"
            look = f'stroke-width="1.6" {head(colour)}'
            yield line([(a, y), (b, end)], colour, look)
            high = y + (GAP if down else -GAP)
            middle = a + (b - a) * (high - y) / (end - y)
            yield (
                f'<circle cx="{middle:.1f}" cy="{high:.1f}" r="8.5" '
                f'fill="var(--paper)" stroke="var(--{colour})"/>'
            )
            number = str(link.number)
            look = "aged" if colour == "aged" else "tie"
            yield text(middle, high + 4, number, f"small {look}", "middle")

    def _oldest(self, link: Linked, used: Mapping[int, int]) -> Taken | None:
        """Return the oldest value taken that is in the picture, at a free instant."""
        found = [
            t
            for t in self.shown.taken
            if (t.source, t.sink) == link[1:3] and t.stems >= self.shown.first
        ]
        if not found:
            return None
        most = max(t.at - t.stems for t in found)
        fit = [t for t in found if t.at - t.stems == most]
        return min(fit, key=lambda t: used.get(t.at, 0))

    def _list(self) -> Iterator[str]:
        y = self.foot + 20
        columns = (12.0, 40.0, 470.0, 620.0)
        heads = ("", "link", f"age when taken ({self.unit})", "why")
        for x, said in zip(columns, heads, strict=True):
            yield text(x, y, said, "soft small")
        for link in self.links:
            y += LINE
            low, high = self.told(link.age.youngest), self.told(link.age.oldest)
            age = low if low == high else f"{low} to {high}"
            look = "aged" if link.age.oldest else ""
            ends = f"{link.source} → {link.sink}: "
            whole = ends + ", ".join(link.signals)
            yield text(columns[0], y, str(link.number), "small tie")
            yield text(columns[1], y, _fitting(whole, 415), "small", tip=whole)
            yield text(columns[2], y, age, f"small {look}")
            remark = link.age.remark
            yield text(columns[3], y, _fitting(remark, 340), "small soft", tip=remark)
        y += LINE + 6
        legend = (
            "strong mark: tick or end of a step; shade: held value or step; hook: "
            "latency; numbered arrow: from where a value stems to where it is taken"
        )
        yield text(12, y, legend, "soft small")


def _links(plan: Plan) -> Iterator[Linked]:
    found: dict[tuple[object, ...], list[Age]] = {}
    for age in plan.ages:
        ends = (age.source.partition(".")[0], age.sink.partition(".")[0])
        key = (*ends, age.youngest, age.oldest, age.remark)
        found.setdefault(key, []).append(age)
    for number, ages in enumerate(found.values(), 1):
        source, sink = ages[0].source.partition(".")[0], ages[0].sink.partition(".")[0]
        signals = tuple(age.source.partition(".")[2] for age in ages)
        yield Linked(number, source, sink, signals, ages[0])


def _about(part: Part) -> str:
    component = part.component
    told = f"{rate(component.period)}, {part.kind}"
    if component.latency:
        told += f", latency {component.latency}"
    return told + (f", offset {component.offset} s" if component.offset else "")


def _fitting(said: str, width: float) -> str:
    while width_of(said, 11.5) > width:
        said = said.removesuffix("…")[:-1] + "…"
    return said
