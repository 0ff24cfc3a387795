"""An FMU in a process of its own cannot take the run, or anything else, along."""

import multiprocessing as mp
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from broken import MISBEHAVES, MODES, pack
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu
from orchestrator.instances import child, isolated
from orchestrator.master.simulate import Choice, simulate
from orchestrator.result import Result
from orchestrator.system import Component, Isolation, System

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the ill-behaved FMU is written for POSIX"
)
APART = Isolation(process=True)
EXECUTORS: list[Choice] = ["kernel", "python"]


@pytest.fixture(scope="session")
def misbehaves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack("misbehaves", MISBEHAVES, tmp_path_factory.mktemp("broken"))


@pytest.fixture
def left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[Any]]:
    """Return what this test left behind: processes, their groups, folders."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    children: list[int] = []
    spawn = child.spawn

    def noted(*arguments: Any) -> Any:
        process = spawn(*arguments)
        children.append(process.pid)
        return process

    def alive(group: int) -> bool:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        return True

    monkeypatch.setattr(child, "spawn", noted)
    return lambda: [
        *mp.active_children(),
        *filter(alive, children),
        *temporary.iterdir(),
    ]


def bad(fmu: Path, mode: str, isolation: Isolation = APART) -> System:
    """Return a system whose FMU misbehaves in the step from 5 ms."""
    component = Component(
        "bad",
        fmu,
        Fraction("1/1000"),
        parameters={"mode": MODES.index(mode), "at": 0.005},
        isolation=isolation,
    )
    return system(
        "1/100",
        [component, part("ours", "counter", "1/1000")],
        {"bad.u": "ours.k"},
        {"bad.y": "1/1000"},
    )


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize(
    ("mode", "said"),
    [
        (
            "segfault",
            r"ended with signal 11 \(SIGSEGV\) during doStep of 0.001 s at t =",
        ),
        ("abort", r"ended with signal 6 \(SIGABRT\) during doStep of 0.001 s at t = 0"),
        (
            "exit",
            r"ended with exit code 7 during doStep of 0.001 s at t = 0.005 s.*u =",
        ),
        ("hang", r"no answer within 0.5 s \(answer_within\) in doStep of 0.001 s at t"),
        ("error", r"doStep of 0.001 s at t = 0.005 s returned Error.*motor is on fire"),
        ("fatal", r"doStep of 0.001 s at t = 0.005 s returned Fatal.*motor is on fire"),
        ("discard", r"doStep of 0.001 s at t = 0.005 s returned Discard.*on fire"),
        ("nan", r"bad \(misbehaves.fmu\): y is nan at t = 0.006 s"),
        ("memory", r"its process ended with signal 6.*memory_limit is 200 MB"),
    ],
)
def test_what_an_isolated_fmu_does_wrong_ends_the_run_by_name_and_leaves_nothing(
    misbehaves: Path,
    tmp_path: Path,
    left: Callable[[], list[Any]],
    mode: str,
    said: str,
    executor: Choice,
) -> None:
    within = 0.5 if mode == "hang" else 30.0
    isolation = Isolation(True, within, 200e6 if mode == "memory" else None)
    with pytest.raises(SimulationError, match=said) as caught:
        simulate(bad(misbehaves, mode, isolation), tmp_path / "run", executor=executor)
    assert str(caught.value).startswith("bad (misbehaves.fmu): ")
    kept = Result(tmp_path / "run")["bad.y"]
    np.testing.assert_allclose(kept.values, [0, 0.001, 1.002, 2.003, 3.004, 4.005])
    assert left() == []


@pytest.mark.parametrize("mode", ["thread", "hang_when_freed"])
def test_what_an_fmu_leaves_running_ends_with_the_run(
    misbehaves: Path,
    tmp_path: Path,
    left: Callable[[], list[Any]],
    mode: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(isolated, "ENDING_WITHIN", 0.5)
    result = simulate(bad(misbehaves, mode), tmp_path / "run")
    assert len(result["bad.y"]) == 11
    assert left() == []


@pytest.mark.parametrize("executor", EXECUTORS)
def test_isolated_components_give_the_bits_of_the_others(
    misbehaves: Path, tmp_path: Path, executor: Choice
) -> None:
    parts = [
        part("plant", "integrator", "1/250"),
        part("seen", "counter", "1/400", latency=1, offset="1/1200", fmi=3),
    ]
    wires = {"plant.u": "seen.rate", "seen.u": "plant.y"}
    rows = {name: "1/1200" for name in ("plant.y", "seen.seen", "seen.k")}
    results = []
    for i, apart in enumerate([(False, False), (True, False), (True, True)]):
        components = [
            replace(c, isolation=Isolation(process=p))
            for c, p in zip(parts, apart, strict=True)
        ]
        given = system("1/5", components, wires, rows)
        done = simulate(given, tmp_path / str(i), executor=executor)
        results.append(np.array([done[name].values for name in rows]))
    assert np.any(results[0])
    for other in results[1:]:
        np.testing.assert_array_equal(other, results[0])


def test_requests_through_pipe_and_memory_never_overtake_each_other() -> None:
    description = read_fmu(part("one", "counter", "1/1000").fmu)
    count = description.variables["k"]
    quick = Isolation(process=True, answer_within=10.0)
    with unpacked(description.path) as folder:
        one = isolated.IsolatedInstance("one", description, folder, print, quick)
        try:
            one.instantiate()
            one.set_up(0.0, None, None)
            one.enter_initialization()
            vector = np.zeros(1)
            one.bind(vector, [], 0, [count], 0)
            one.exit_initialization()
            for k in range(1000):
                one.step(k / 1000, 1 / 1000)
                one.pull()
                assert one.read([count]) == [vector[0]] == [float(k)]
        finally:
            one.close()


def test_without_a_compiler_an_isolated_fmu_runs_all_the_same(
    misbehaves: Path,
    tmp_path: Path,
    left: Callable[[], list[Any]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from fmus.compile import CompileError

    whole = simulate(bad(misbehaves, "well"), tmp_path / "whole")

    def none() -> None:
        raise CompileError("there is no compiler")

    monkeypatch.setattr(isolated.c, "library", none)
    result = simulate(bad(misbehaves, "well"), tmp_path / "run")
    np.testing.assert_array_equal(result["bad.y"].values, whole["bad.y"].values)
    with pytest.raises(
        SimulationError, match=r"SIGSEGV.*doStep of 0.001 s at t = 0.005"
    ):
        simulate(bad(misbehaves, "segfault"), tmp_path / "run")
    assert left() == []


def test_a_script_without_a_main_guard_may_isolate(
    misbehaves: Path, tmp_path: Path
) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        f"""
from fractions import Fraction
from pathlib import Path
from orchestrator.master.simulate import simulate
from orchestrator.system import Component, Isolation, System

print("begun")
isolation = Isolation(process=True)
T = Fraction("1/1000")
bad = Component("bad", Path({str(misbehaves)!r}), T, isolation=isolation)
system = System("x", 10 * T, {{"bad": bad}}, {{}}, {{"bad.y": (T,)}})
print(len(simulate(system, Path({str(tmp_path)!r}))["bad.y"]))
"""
    )
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, timeout=120
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["begun", "11"]


def test_a_daemon_that_may_start_no_process_is_told_so(
    misbehaves: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(mp.current_process()._config, "daemon", True)  # type: ignore[attr-defined]
    with pytest.raises(SimulationError, match=r"^bad.*ProcessPoolExecutor"):
        simulate(bad(misbehaves, "well"), tmp_path)
