"""One table, type x place: what every type of FMI 2.0 and 3.0 answers everywhere.

A place takes the right values of a type exactly and refuses wrong ones, or refuses
all of them, in words and before anything runs (exit code 2).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from typed import ITEMS, TYPES, typed

from fmus.trust import trust
from orchestrator.checks.engine import check_fmu
from orchestrator.errors import FeedDriveError, SimulationError, WiringError
from orchestrator.master.simulate import Choice, simulate
from orchestrator.outcome import Run
from orchestrator.scenario.reading import scenario_from
from orchestrator.session import run
from orchestrator.system import Component, Isolation, System

TEXTS = ("String", "Binary")
REALS = {"Real": 0.1, "Float64": 0.1, "Float32": 0.5}


def values(fmi: int, kind: str) -> tuple[list[Any], list[Any]]:
    """Return right and wrong values of a type."""
    if kind in REALS:
        return [REALS[kind], -3], [True, "fast", *([1e39] if kind == "Float32" else [])]
    if kind == "Boolean":
        return [True, 1], [0.3, 2, "on"]
    if kind == "Enumeration":
        return ["fast", 2], [3, 2.5, True, "fats"]
    if kind == "String":
        return ["kg \u00e4 3"], [3, True]
    if kind == "Binary":
        return ["00 ff10"], [3, "0g"]
    if kind == "Clock":
        return [], [1, True, "x"]
    bits = 32 if kind == "Integer" else int(kind.rpartition("t")[2])
    unsigned = kind.startswith("U")
    low = 0 if unsigned else -(2 ** (bits - 1))
    high = 2**bits - 1 if unsigned else 2 ** (bits - 1) - 1
    return [high, low], [2.9, high + 1, low - 1, True, "3"]


def number(value: Any) -> Any:
    """Return what is recorded of a right value."""
    if isinstance(value, str):
        return ITEMS[value]
    return int(value) if value is True else value


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Mapping[int, Path]:
    """Both are trusted: else each of a thousand runs would be a child of its own."""
    folder = tmp_path_factory.mktemp("types")
    built = {fmi: typed(fmi, folder) for fmi in (2, 3)}
    for fmu in built.values():
        trust(fmu)
    return built


class Trial:
    """Runs small scenarios of two FMUs of types, ``a`` and ``b``."""

    def __init__(self, fmu: Path, kind: str, folder: Path) -> None:
        self.fmu, self.kind, self.folder, self.count = fmu, kind, folder, 0

    def run(self, tables: Mapping[str, Any], **of_a: Any) -> Run:
        component = {"fmu": str(self.fmu), "step": "1/100", "isolation": "none"}
        raw = {
            "stop": "1/50",
            "components": {"a": {**component, **of_a}, "b": component},
            **tables,
        }
        self.count += 1
        scenario = scenario_from(raw, self.folder / "types.toml")
        return run(scenario, self.folder / str(self.count), report=False)

    def recorded(self, done: Run, name: str) -> Any:
        return done[name].values[-1].item()


def parameter(t: Trial, value: Any) -> Any:
    name, numeric = f"p_{t.kind}", t.kind not in TEXTS
    rows = {"record": {f"a.{name}": True} if numeric else {}}
    done = t.run(rows, parameters={name: value})
    lock = (done.folder / "scenario.lock.toml").read_text()
    assert name in lock
    return t.recorded(done, f"a.{name}") if numeric else "set"


def start(t: Trial, value: Any) -> Any:
    name, numeric = f"in_{t.kind}", t.kind not in TEXTS
    rows = {"record": {f"a.{name}": True} if numeric else {}}
    done = t.run(rows, start={name: value})
    return t.recorded(done, f"a.{name}") if numeric else "set"


def constant(t: Trial, value: Any) -> Any:
    name = f"a.in_{t.kind}"
    done = t.run({"connections": {name: value}, "record": {name: True}})
    return t.recorded(done, name)


def connection(t: Trial, value: Any) -> Any:
    wire = {f"b.in_{t.kind}": f"a.out_{t.kind}"}
    tables = {"connections": wire, "record": {f"b.out_{t.kind}": True}}
    return t.recorded(t.run(tables, **started(t, value)), f"b.out_{t.kind}")


def star(t: Trial, value: Any) -> Any:
    tables = {"connections": {"b.in_*": "a.out_*"}, "record": {"b.*": True}}
    name = f"in_{t.kind}"
    done = t.run(tables, start={name: value} if t.kind != "Clock" else {})
    if t.kind in TEXTS:
        left = [w for w in done.warnings if f"leaves out b.out_{t.kind}" in w]
        left += [w for w in done.warnings if f"leaves out b.in_{t.kind}" in w]
        assert len(left) == 2
        assert f"b.out_{t.kind}" not in done
        return "left out"
    if t.kind == "Clock":
        assert "b.in_Clock" not in done
        return "left out"
    return t.recorded(done, f"b.out_{t.kind}")


def mapped(t: Trial, value: Any) -> Any:
    name, numeric = f"in_{t.kind}", t.kind not in TEXTS
    table = {"x": {"name": name, **({"gain": 1} if numeric else {})}}
    record = {"record": {"a.x": True} if numeric else {}}
    done = t.run(record, map=table, start={"x": value})
    return t.recorded(done, "a.x") if numeric else "set"


def record(t: Trial, value: Any) -> Any:
    done = t.run({"record": {f"a.out_{t.kind}": True}}, **started(t, value))
    return t.recorded(done, f"a.out_{t.kind}")


def metric(t: Trial, value: Any) -> Any:
    of = f"a.out_{t.kind}"
    figure = {"m": {"kind": "final", "of": of}}
    rows = {of: True} if t.kind not in (*TEXTS, "Clock") else {}
    done = t.run({"record": rows, "metrics": figure}, **started(t, value))
    figure = done.metrics["m.final"]
    return figure.value if figure.value == figure.value else f"none: {figure.why}"


def fault(t: Trial, value: Any) -> Any:
    sink = f"b.in_{t.kind}"
    tables = {
        "connections": {sink: f"a.out_{t.kind}"} if t.kind != "Clock" else {},
        "faults": {sink: {"kind": "override", "value": value, "window": [0.005, 1]}},
        "record": {sink: True},
    }
    return t.recorded(t.run(tables), sink)


def started(t: Trial, value: Any) -> dict[str, Any]:
    return {} if t.kind == "Clock" else {"start": {f"in_{t.kind}": value}}


WAYS: Mapping[str, Callable[[Trial, Any], Any]] = {
    "parameter": parameter,
    "start": start,
    "constant": constant,
    "connection": connection,
    "star": star,
    "map": mapped,
    "record": record,
    "metric": metric,
    "fault": fault,
}
GIVES = ("parameter", "start", "constant", "map", "fault")  # places that take a value
NO_TEXTS = ("constant", "connection", "record", "metric", "fault")


def answer(t: Trial, place: str, value: Any) -> Any:
    """Return what a place makes of a value, or the refusal."""
    try:
        return WAYS[place](t, value)
    except FeedDriveError as error:
        return error if error.exit_code == 2 else f"exit {error.exit_code}: {error}"


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_type_has_an_answer_in_every_place(
    fmus: Mapping[int, Path],
    fmi: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = []
    for kind in TYPES[fmi]:
        folder = tmp_path / kind
        folder.mkdir()
        row = {p: told(Trial(fmus[fmi], kind, folder / p), fmi, p) for p in WAYS}
        rows.append([f"FMI {fmi} {kind}", *row.values()])
    with capsys.disabled():
        print()
        for line in [["type", *WAYS], *rows]:
            print(" | ".join(f"{cell:22.22}" for cell in line))


def told(t: Trial, fmi: int, place: str) -> str:
    """Return a cell of the table, having asserted what it says."""
    t.folder.mkdir(exist_ok=True)
    right, wrong = values(fmi, t.kind)
    if t.kind == "Clock":
        found = answer(t, place, 1)
        assert place == "star" or "Clock" in str(found)
        return "left out" if place == "star" else "refused: a Clock"
    if t.kind in TEXTS and place in NO_TEXTS:
        found = answer(t, place, right[0])
        assert isinstance(found, FeedDriveError), (place, found)
        return "refused: texts"
    cells = []
    for value in right:
        found = answer(t, place, value)
        cells.append(str(value) if t.kind in TEXTS else str(found))
        if t.kind in TEXTS:
            assert found in ("set", "left out"), (place, value, found)
        elif place in ("fault", "constant") and isinstance(value, str):
            cells[-1] = f"no {value}"  # a text is a source there, or nothing
        elif place == "metric" and abs(number(value)) > 2**53:
            assert "digits" in str(found), (place, value, found)
            cells[-1] = "none: digits"
        else:
            assert found == number(value), (place, value, found)
    for value in wrong if place in GIVES else ():
        found = answer(t, place, value)
        assert isinstance(found, FeedDriveError), (place, value, found)
    if t.kind in TEXTS and place == "star":
        return "left out"
    refused = f"; {len(wrong)} refused" if place in GIVES else ""
    return ", ".join(cells) + refused


@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize("executor", ["kernel", "python"])
def test_64_bit_integers_keep_every_digit_in_every_executor(
    fmus: Mapping[int, Path], executor: Choice, apart: bool, tmp_path: Path
) -> None:
    step, isolation = Fraction(1, 100), Isolation(process=apart)
    given = {"in_Int64": -(2**63) + 1, "in_UInt64": 2**64 - 1, "in_Float64": 0.1}
    a, b = (
        Component(name, fmus[3], step, kind="sampled", latency=n, isolation=isolation)
        for name, n in (("a", 1), ("b", 0))
    )
    a = replace(a, start=given)
    kinds = ("Int64", "UInt64", "Float64")
    wires = {f"b.in_{kind}": f"a.out_{kind}" for kind in kinds}
    rows = {f"b.out_{kind}": (step,) for kind in kinds}
    system = System("t", 3 * step, {"a": a, "b": b}, wires, rows)
    found = simulate(system, tmp_path, executor=executor)
    for kind, value in zip(kinds, given.values(), strict=True):
        assert found[f"b.out_{kind}"].values.tolist() == [value] * 4


def test_digits_that_a_number_with_a_point_does_not_hold_are_refused_or_asked_for(
    fmus: Mapping[int, Path], tmp_path: Path
) -> None:
    t = Trial(fmus[3], "Int64", tmp_path)
    wires = {"connections": {"b.in_Float64": "a.out_Int64"}}
    rows = {"record": {"b.in_Float64": True}}
    with pytest.raises(SimulationError, match="9007199254740993 has more digits"):
        t.run({**wires, **rows}, start={"in_Int64": 2**53 + 1})
    done = t.run({**wires, **rows}, start={"in_Int64": 2**53 - 1})
    assert t.recorded(done, "b.in_Float64") == 2**53 - 1
    scaled = {"out_Int64": {"name": "out_Int64", "gain": 1e-9}}
    done = t.run({**wires, **rows}, start={"in_Int64": 2**53 + 1}, map=scaled)
    assert t.recorded(done, "b.in_Float64") == pytest.approx(2**53 * 1e-9)


@pytest.mark.parametrize("fmi", [2, 3])
def test_enumerations_and_switches_connect_to_their_like_only(
    fmus: Mapping[int, Path], fmi: int, tmp_path: Path
) -> None:
    integer, real = ("Integer", "Real") if fmi == 2 else ("Int32", "Float64")
    t = Trial(fmus[fmi], real, tmp_path)
    for source, sink in (
        (real, integer),
        (real, "Enumeration"),
        (integer, "Enumeration"),
        ("Boolean", real),
        (integer, "Boolean"),
        ("Boolean", "Enumeration"),
        ("String", real),
        (real, "String"),
    ):
        with pytest.raises(WiringError, match="cannot drive"):
            t.run({"connections": {f"b.in_{sink}": f"a.out_{source}"}})
    wires = {
        f"b.in_{real}": "a.out_Enumeration",
        f"b.in_{integer}": "a.out_Enumeration",
    }
    rows = {name: True for name in wires}
    done = t.run(
        {"connections": wires, "record": rows}, start={"in_Enumeration": "fast"}
    )
    assert [t.recorded(done, name) for name in wires] == [4, 4]


@pytest.mark.parametrize("fmi", [2, 3])
def test_check_finds_no_fault_in_start_values_of_any_type(
    fmus: Mapping[int, Path], fmi: int
) -> None:
    report = check_fmu(fmus[fmi], only=(8, 9))
    assert {o.verdict for o in report.outcomes} <= {"pass", "not applicable"}, report
