"""The table feature x executor of docs/executors.md, walked: each cell is tried."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from clocked import clocked as clocked_by_others
from foreign import foreign
from of_others import (
    ending,
    falling,
    faulty_words,
    iterated,
    looked_up,
    offering,
    scheduled,
    talked,
    words,
)
from systems import controller, lag, mixed, part, system
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import FeedDriveError
from orchestrator.master.checkpoint import Checkpoints, Keeper
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.simulate import plan, simulate
from orchestrator.master.warm import origin
from orchestrator.result import Result, Signal, reached
from orchestrator.signals.recording import Recording, play
from orchestrator.system import Component, Fault, Injection, Isolation, Mapped, System

PAGE = Path(__file__).parents[3] / "docs" / "executors.md"
EXECUTORS = ("python", "kernel", "fused", "lanes")


CHECKPOINT = "checkpoint and resume"
WARM = "begin at a kept checkpoint (--from)"
PACE = "held to the clock (pace)"


def pair(**options: object) -> System:
    parts = [
        part("a", "counter", "1/1000"),
        replace(part("b", "counter", "1/1000"), **options),
    ]
    return system("1/100", parts, {"b.u": "a.k"}, {"b.seen": "1/1000"})


def circle(g: float) -> System:
    parts = [
        part(n, "integrator", "1/10", start={"state.x": 1.0}, parameters={"g": g})
        for n in "ab"
    ]
    wires = {"a.u": "b.z", "b.u": "a.z"}
    return system("1/10", parts, wires, {"a.z": "1/10"})


def faulty(*faults: Fault) -> System:
    return replace(pair(), faults={"b.u": faults})


def all_faults() -> System:
    start, end = Fraction(2, 1000), Fraction(7, 1000)
    kinds = [("bias", 0.3), ("gain", 1.7), ("quantisation", 0.4)]
    laws = [Fault(kind, value, 0, start, end) for kind, value in kinds]  # type: ignore[arg-type]
    late = Fault("delay", 0.0, 2, Fraction(0), None)
    stuck = Fault("stuck", 0.0, 0, Fraction(8, 1000), Fraction(9, 1000))
    instead = Fault("override", -0.1, 0, Fraction(9, 1000), None)
    return faulty(*laws, late, stuck, instead)


def injected(where: str) -> System:
    """A signal of three values at a connection behind a latency, or at a free input."""
    given = pair(map={"u": Mapped("u", -2.0, 0.5)}, latency=1)
    if where == "free":
        given = replace(given, connections={})
    return replace(given, injections={"b.u": Injection((0.1, -0.7, 1.3))})


def injected_continuous() -> System:
    given = unsplit()
    split = replace(given.components["plant"], split=None)
    parts = {**given.components, "plant": split}
    signal = Injection((1.0, 2.0, 4.0))
    return replace(given, components=parts, injections={"plant.u": signal})


def clocked() -> System:
    parts = [
        part("a", "counter", "1/1000", fmi=3),
        part("b", "counter", "1/400", fmi=3),
    ]
    return system("1/100", parts, {"b.u": "a.k"}, {"b.seen": "1/400"})


def twice() -> System:
    given = pair()
    rates = (Fraction(1, 1000), Fraction(1, 500))
    return replace(given, record={"b.seen": rates})


def others_clock(tmp_path: Path) -> System:
    file = clocked_by_others(tmp_path)
    one = Component("c", file, Fraction(1, 1000), isolation=Isolation(process=False))
    rows = {f"c.{name}": "1/1000" for name in "nywz"}
    return system("1/100", [part("a", "counter", "1/1000"), one], {"c.u": "a.k"}, rows)


def alien(tmp_path: Path) -> System:
    file = foreign(2, tmp_path)
    one = Component(
        "alien", file, Fraction(1, 1000), isolation=Isolation(process=False)
    )
    return system(
        "1/100",
        [part("a", "counter", "1/1000"), one],
        {"alien.in_Real": "a.k"},
        {"alien.out_Real": "1/1000", "a.k": "1/1000"},
    )


def rounded(tmp_path: Path) -> System:
    """A slope that saturates at the end of a range, and one that is counted on."""
    given = alien(tmp_path)
    gain, laws = 2.0**31 / 3.3, {"one": "saturate", "two": "wrap"}
    parts = {
        name: replace(
            given.components["alien"],
            name=name,
            map={"in": Mapped("in_Integer", gain, 0.3, range=law)},  # type: ignore[arg-type]
        )
        for name, law in laws.items()
    }
    return replace(
        given,
        components={
            "a": given.components["a"],
            "b": part("b", "counter", "1/1000"),
            **parts,
        },
        connections={f"{name}.in": "a.k" for name in parts},
        record={
            name: (Fraction(1, 1000),)
            for name in ("one.out_Integer", "two.out_Integer", "b.k")
        },
    )


def apart(tmp_path: Path) -> System:
    given = alien(tmp_path)
    other = replace(given.components["alien"], isolation=Isolation(process=True))
    return replace(given, components={**given.components, "alien": other})


def signals(folder: Path) -> System:
    """Rows at 1, 3 and 10 ms, on lines between them, played every 2 ms and held."""
    file = folder / "force.csv"
    file.write_text("t [ms],F [1]\n0,0.1\n1,0.7\n3,-0.2\n10,0.4\n")
    found = play(Recording(file, Fraction(1, 500), "linear"))
    parts = [
        Component("force", found.fmu, found.period),
        part("b", "counter", "1/1000"),
    ]
    record = {"force.F": "1/1000", "b.seen": "1/1000"}
    return system("1/50", parts, {"b.u": "force.F"}, record)


def python_fmu() -> System:
    parts = [part("a", "counter", "1/1000"), controller("python")]
    return system("1/100", parts, {}, {"pi.u": "1/1000", "a.k": "1/1000"})


def unsplit() -> System:
    plant = part("plant", "integrator", "1/250", split=False)
    parts = [part("source", "counter", "1/1000"), plant]
    wires = {"plant.u": "source.rate"}
    return system("1/125", parts, wires, {"plant.y": "1/250"})


FEATURES: dict[str, Callable[[Path], System]] = {
    "several rates": lambda _: system(
        "1/100",
        [part("a", "counter", "1/1000"), part("b", "counter", "1/400")],
        {"b.u": "a.k"},
        {"b.seen": "1/2000"},
    ),
    "offset": lambda _: pair(offset=Fraction(1, 3000)),
    "latency": lambda _: pair(latency=2),
    "gain and offset of a map": lambda _: pair(map={"u": Mapped("u", -2.0, 0.5)}),
    "whole numbers in a range of a map": rounded,
    "one signal at several rates": lambda _: twice(),
    "dead time and own integration": lambda _: lag(),
    "faults": lambda _: all_faults(),
    "injection at a connection": lambda _: injected("connection"),
    "injection between steps": lambda _: injected_continuous(),
    "injection at a free input": lambda _: injected("free"),
    "initial circle by substitution": lambda _: circle(0.5),
    "initial circle by Newton": lambda _: circle(2.0),
    "FMI 3 clock": lambda _: clocked(),
    "FMI 3 clock of an FMU of others": others_clock,
    "step not split (split = false)": lambda _: unsplit(),
    "group that is iterated": iterated,
    "texts and bytes": talked,
    "table of a map": looked_up,
    "intermediate update and early return offered": offering,
    "scheduled execution": scheduled,
    "64-bit integers": words,
    "faults of 64-bit integers": faulty_words,
    "FMU of others": alien,
    "FMU in a process of its own": apart,
    "signals of a file": signals,
    "Python FMU": lambda _: python_fmu(),
    "FMU that ends the run": ending,
    "model exchange with state events": falling,
    PACE: lambda _: mixed(),
    CHECKPOINT: lambda _: mixed(),
    WARM: lambda _: mixed(),
}


def written() -> dict[str, dict[str, str]]:
    """Return the table of the page: feature -> executor -> what stands there."""
    lines = [x for x in PAGE.read_text(encoding="utf-8").splitlines() if x[:1] == "|"]
    head, _, *rows = ([c.strip() for c in x.strip("|").split("|")] for x in lines)
    return {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in rows}


def resumed(given: System, executor: str, folder: Path) -> Result:
    """Interrupt a run behind its tenth checkpoint, and go on with it."""
    place, kept = folder / executor, Checkpoints(Fraction(1, 1000))
    options = {"executor": executor, "checkpoints": kept}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Keeper, "write", interrupting(Keeper.write))
        with pytest.raises(KeyboardInterrupt):
            simulate(given, place, **options)  # type: ignore[arg-type]
    assert 0 < (reached(place) or 0) < float(given.stop)
    options["checkpoints"] = replace(kept, resumed=True)
    return simulate(given, place, **options)  # type: ignore[arg-type]


def begun(given: System, executor: str, folder: Path) -> dict[str, Signal]:
    """The rows of a run up to a checkpoint, and of one that begins there."""
    time, kept = Fraction(1, 125), Checkpoints(Fraction(1, 1000), kept=True)
    whole = simulate(given, folder / "whole", checkpoints=kept)
    there = origin("it", folder / "whole", time)
    rest = simulate(given, folder / executor, executor=executor, origin=there)  # type: ignore[arg-type]
    found = {}
    for name, signal in whole.items():
        before = signal.values[signal.time < float(time)]
        values = np.concatenate([before, rest[name].values])
        found[name] = replace(signal, values=values)
    return found


def interrupting(write: Callable[..., None]) -> Callable[..., None]:
    calls = count(1)

    def instead(*arguments: object) -> None:
        write(*arguments)
        if next(calls) == 10:
            raise KeyboardInterrupt

    return instead


def carried_out(
    given: System, executor: str, folder: Path, feature: str = ""
) -> dict[str, Signal]:
    options = {CHECKPOINT: "--checkpoint", PACE: "--pace", WARM: "--from"}
    if feature in options and executor == "lanes":
        option = options[feature]
        verb = ["sweep", "x", option, "1"]
        raise FeedDriveError(CliRunner().invoke(app, verb).output)
    if executor == "lanes":
        (member,) = Lanes(plan(given), frozenset(given.record), 4).run([{}])
        assert not member.unsettled
        if member.failure is not None:
            raise member.failure
        return dict(member.signals)
    if feature == CHECKPOINT:
        return dict(resumed(given, executor, folder))
    if feature == WARM:
        return begun(given, executor, folder)
    kind = {"executor": executor, "pace": 1.0 if feature == PACE else None}
    done: Result = simulate(given, folder / executor, **kind)  # type: ignore[arg-type]
    return dict(done)


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_runs_with_the_same_bits_or_is_refused_in_words(
    feature: str, tmp_path: Path
) -> None:
    given = FEATURES[feature](tmp_path)
    reference: dict[str, Signal] = {}
    if written()[feature]["python"].startswith("runs"):
        reference = carried_out(given, "python", tmp_path)
    for executor in EXECUTORS:
        cell = written()[feature][executor]
        if cell.startswith("runs"):
            found = carried_out(given, executor, tmp_path / "again", feature)
            for name, signal in reference.items():
                np.testing.assert_array_equal(found[name].values, signal.values)
        else:
            with pytest.raises(FeedDriveError) as refused:
                carried_out(given, executor, tmp_path / "again", feature)
            assert cell.removeprefix("refused: ").strip('"') in str(refused.value)


def test_every_feature_has_its_row() -> None:
    assert list(written()) == list(FEATURES)
