"""Systems with FMUs of others, for the table of executors and features."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from broken import ball, pack
from coupled import OFFERS, coupled
from foreign import foreign
from outcomes import outcomes
from systems import part, system
from talking import talking

from orchestrator.system import (
    Component,
    Fault,
    Isolation,
    Iterated,
    Mapped,
    System,
)


def ending(folder: Path) -> System:
    step, here = Fraction(1, 1000), Isolation(process=False)
    how = {"how": 1.0, "at": 0.004}  # asks to end behind a whole step
    one = Component("one", outcomes(3, folder), step, parameters=how, isolation=here)
    rows = {"one.t": "1/1000", "a.k": "1/1000"}
    parts = [part("a", "counter", "1/1000"), one]
    return system("1/100", parts, {"one.u": "a.k"}, rows)


def falling(folder: Path) -> System:
    here = Isolation(process=False)
    file = pack("ball", ball(2), folder)
    one = Component("ball", file, Fraction(1, 10), isolation=here)
    rows = {"ball.bounces": "1/10", "ball.h": "1/10"}
    return system("1", [part("a", "counter", "1/10"), one], {"ball.u": "a.k"}, rows)


def words(folder: Path) -> System:
    here, step = Isolation(process=False), Fraction(1, 1000)
    file = foreign(3, folder)
    one, two = (Component(n, file, step, isolation=here) for n in ("one", "two"))
    return system(
        "1/100",
        [part("a", "counter", "1/1000"), one, two],
        {"two.in_Int64": "one.out_Int64"},
        {"two.out_Int64": "1/1000", "a.k": "1/1000"},
    )


def faulty_words(folder: Path) -> System:
    """The values given have more digits than a double."""
    given, MS = words(folder), Fraction(1, 1000)
    late = Fault("delay", 0.0, 1, Fraction(0), 3 * MS)
    stuck = Fault("stuck", 0.0, 0, 4 * MS, 6 * MS)
    instead = Fault("override", -7.0, 0, 8 * MS, None)
    return replace(given, faults={"two.in_Int64": (late, stuck, instead)})


def iterated(folder: Path) -> System:
    """Two sampled FMUs whose loop Newton's method solves at every tick."""
    step, here = Fraction(1, 1000), Isolation(process=False)
    file = coupled(3, folder)
    parts = [
        Component(
            name,
            file,
            step,
            kind="sampled",
            parameters={"a": a, "b": 1.0},
            isolation=here,
        )
        for name, a in (("one", 3.0), ("two", -2.0))
    ]
    wires = {"one.u": "two.y", "two.u": "one.y"}
    given = system("1/100", parts, wires, {"one.y": str(step), "two.n": str(step)})
    return replace(given, groups={"both": Iterated(("one", "two"))})


def talked(folder: Path) -> System:
    """A text and bytes from one FMU to the other, numbers beside them."""
    step, here = Fraction(1, 1000), Isolation(process=False)
    file = talking(3, folder)
    parts = [Component(name, file, step, isolation=here) for name in ("one", "two")]
    wires = {"two.heard": "one.text", "two.data": "one.bytes"}
    return system("1/100", parts, wires, {"one.k": str(step), "two.k": str(step)})


def looked_up(folder: Path) -> System:
    """Integers from -1 on, each through a table that is no line."""
    step, here = Fraction(1, 1000), Isolation(process=False)
    file = foreign(2, folder)
    one, two = (Component(n, file, step, isolation=here) for n in ("one", "two"))
    listed = tuple((k, k * k % 7) for k in range(-1, 20))
    two = replace(two, map={"in": Mapped("in_Integer", table=listed)})
    wires = {"two.in": "one.out_Integer"}
    return system("1/100", [one, two], wires, {"two.out_Integer": str(step)})


def offering(folder: Path) -> System:
    """An FMU that offers both and is instantiated only where nobody asks for them."""
    here = Isolation(process=False)
    file = coupled(3, folder, interface=OFFERS)
    one = Component(
        "one", file, Fraction(1, 1000), parameters={"a": 2.0}, isolation=here
    )
    rows = {"one.y": "1/1000", "one.n": "1/1000"}
    parts = [part("a", "counter", "1/1000"), one]
    return system("1/100", parts, {"one.u": "a.k"}, rows)


def scheduled(folder: Path) -> System:
    """An FMU whose tasks the importer's clocks would have to run."""
    file = coupled(3, folder, interface="", kind="ScheduledExecution")
    one = Component("one", file, Fraction(1, 1000))
    return system("1/100", [one], {}, {"one.y": "1/1000"})
