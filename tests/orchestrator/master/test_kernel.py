"""The kernel moves every type, fails with the reference's words, and gives way."""

import logging
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from foreign import TYPES, foreign
from systems import part, system, trusted

import orchestrator.native.library
from fmus.compile import PLATFORMS, CompileError, compile_alone
from orchestrator.errors import SimulationError
from orchestrator.master.simulate import Choice, simulate
from orchestrator.native.library import SOURCES
from orchestrator.result import Result
from orchestrator.system import Component, Isolation, Mapped, System

HERE = Isolation(process=False)  # in this process
EXECUTORS: tuple[Choice, Choice] = ("python", "kernel")


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("foreign")
    return {fmi: trusted(foreign(fmi, folder)) for fmi in (2, 3)}


def chain(fmu: Path, fmi: int, stop: str = "1/100", **parameters: float) -> System:
    """Return a ring of two foreign FMUs through all their types."""
    step = Fraction(1, 1000)
    maps = {f"in_{TYPES[fmi][0]}": Mapped(f"in_{TYPES[fmi][0]}", -1.25, 3.0)}
    one = Component("one", fmu, step, map=maps, isolation=HERE)
    two = Component("two", fmu, step, parameters=parameters, isolation=HERE)
    names = [*TYPES[fmi], *(["two"] if fmi == 3 else [])]
    wires = {f"two.in_{name}": f"one.out_{name}" for name in names}
    wires |= {f"one.in_{name}": f"two.out_{name}" for name in names}
    rows = {f"{c}.out_{name}": "1/1000" for c in ("one", "two") for name in names}
    return system(stop, [one, two], wires, rows)


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_type_passes_between_fmus(
    fmus: dict[int, Path], fmi: int, tmp_path: Path
) -> None:
    given = chain(fmus[fmi], fmi)
    python, native = (simulate(given, tmp_path / e, executor=e) for e in EXECUTORS)
    moved = 0
    for name in python:
        np.testing.assert_array_equal(python[name].values, native[name].values)
        moved += bool(np.any(native[name].values))
    assert moved == len(native)


def failure(given: System, executor: Choice, folder: Path) -> tuple[str, Result]:
    with pytest.raises(SimulationError) as caught:
        simulate(given, folder / executor, executor=executor)
    return str(caught.value), Result(folder / executor)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("how", "words"),
    [
        (
            1,
            r"two \(foreign\d\.fmu\): doStep of 0\.001 s at t = 0\.004 s returned E",
        ),
        (2, r"get \w+ \(out_\w+, \.\.\.\) at t = 0\.004 s returned Error"),
        (3, r"set \w+ \(in_\w+, \.\.\.\) at t = 0\.004 s returned Error"),
        (4, r"out_\w+ is nan at t = 0\.005 s"),
    ],
)
def test_failures_are_told_alike_and_rows_before_stay(
    fmus: dict[int, Path], fmi: int, how: int, words: str, tmp_path: Path
) -> None:
    given = chain(fmus[fmi], fmi, a=5.0, h=float(how))
    (text, rows), (same_text, same_rows) = (
        failure(given, executor, tmp_path) for executor in EXECUTORS
    )
    assert text == same_text
    assert re.search(words, text)
    name = f"one.out_{TYPES[fmi][0]}"
    assert rows[name].time.tolist() == [0, 0.001, 0.002, 0.003, 0.004]
    np.testing.assert_array_equal(rows[name].values, same_rows[name].values)


@pytest.mark.parametrize("fmi", [2, 3])
def test_log_messages_carry_the_time_of_their_step(
    fmus: dict[int, Path], fmi: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    given = chain(fmus[fmi], fmi, a=4.0, h=6.0)
    with caplog.at_level(logging.WARNING, "feeddrive"):
        for executor in EXECUTORS:
            simulate(given, tmp_path, executor=executor)
    assert caplog.messages == ["two at t = 0.003 s: [Warning, speech] it is warm"] * 2


@pytest.mark.parametrize(
    ("gain", "when"),
    [(-2.0, "0.011 s was given 128.0"), (1e3, "0 s was given -1000.0")],
)
def test_a_number_that_does_not_fit_an_integer_is_refused_alike(
    fmus: dict[int, Path], gain: float, when: str, tmp_path: Path
) -> None:
    step = Fraction(1, 1000)
    one = Component(
        "one",
        fmus[3],
        step,
        map={"in_Int8": Mapped("in_Int8", gain)},
        isolation=HERE,
    )
    two = Component("two", fmus[3], step, isolation=HERE)
    wires = {"two.in_Int8": "one.out_Int8", "one.in_Int8": "two.out_Int8"}
    given = system("1/10", [one, two], wires, {"one.out_Int8": "1/1000"})
    texts = []
    for executor in EXECUTORS:
        with pytest.raises(SimulationError) as caught:
            simulate(given, tmp_path, executor=executor)
        texts.append(str(caught.value))
    assert texts[0] == texts[1]
    assert f"set Int8 (in_Int8, ...) at t = {when}, but takes whole numbers" in texts[0]


def test_without_a_compiler_python_takes_over_with_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def missing() -> None:
        raise CompileError("the C compiler is missing: pip install it")

    given = system("1/100", [part("c", "counter", "1/1000")], record={"c.k": "1/1000"})
    monkeypatch.setattr(orchestrator.native.library, "library", missing)
    with caplog.at_level(logging.WARNING, "feeddrive"):
        assert len(simulate(given, tmp_path)["c.k"]) == 11
    (message,) = caplog.messages
    assert "compiler is missing" in message
    assert "Python executor is used" in message
    with pytest.raises(SimulationError, match=r"executor kernel.*compiler is missing"):
        simulate(given, tmp_path, executor="kernel")


def test_an_interrupted_run_leaves_its_rows_readable(tmp_path: Path) -> None:
    def interrupt(t: Fraction) -> None:
        raise KeyboardInterrupt

    parts = [part("c", "counter", "1/1000")]
    given = system("100000", parts, record={"c.k": "1/1000"})
    with pytest.raises(KeyboardInterrupt):
        simulate(given, tmp_path, progress=interrupt, executor="kernel")
    kept = Result(tmp_path)["c.k"].values
    assert 0 < len(kept) < 10**8
    np.testing.assert_array_equal(kept, np.arange(len(kept)))


@pytest.mark.parametrize("platform", PLATFORMS)
def test_it_compiles_for_every_platform(platform: str, tmp_path: Path) -> None:
    sources = {file.name: file.read_text(encoding="utf-8") for file in SOURCES}
    assert compile_alone("kernel", sources, platform, tmp_path).is_file()
