"""An FMU that is let into the process of the run takes only that along."""

import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from broken import MISBEHAVES, MODES, pack
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.master.simulate import Choice, simulate
from orchestrator.result import Result
from orchestrator.system import Component, Isolation, System

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the ill-behaved FMU is written for POSIX"
)
EXECUTORS: list[Choice] = ["kernel", "python"]


@pytest.fixture(scope="module")
def misbehaves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack("misbehaves", MISBEHAVES, tmp_path_factory.mktemp("broken"))


def let_in(fmu: Path, mode: str, process: bool = False) -> System:
    bad = Component(
        "bad",
        fmu,
        Fraction("1/1000"),
        parameters={"mode": MODES.index(mode), "at": 0.005},
        isolation=Isolation(process=process),
    )
    ours = part("ours", "counter", "1/1000")
    return system("1/100", [bad, ours], {"bad.u": "ours.k"}, {"bad.y": "1/1000"})


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize(
    ("mode", "how"),
    [("exit", "exit code 7"), ("segfault", r"signal 11 \(SIGSEGV\)")],
)
def test_its_end_is_named_and_not_that_of_the_command(
    misbehaves: Path, tmp_path: Path, mode: str, how: str, executor: Choice
) -> None:
    text = rf"^bad \(misbehaves.fmu\): the process of the run ended with {how} during "
    with pytest.raises(SimulationError, match=text + "doStep"):
        simulate(let_in(misbehaves, mode), tmp_path, executor=executor)
    assert [f.name for f in tmp_path.iterdir()] == ["result"]


@pytest.mark.parametrize("executor", EXECUTORS)
def test_a_run_with_it_gives_the_rows_progress_and_errors_of_any_other(
    misbehaves: Path, tmp_path: Path, executor: Choice
) -> None:
    told: list[Fraction] = []

    def run(mode: str, process: bool, report: Callable[[Fraction], None]) -> Result:
        given = let_in(misbehaves, mode, process)
        folder = tmp_path / f"{mode} {process}"
        return simulate(given, folder, executor=executor, progress=report)

    inside = run("well", False, told.append)
    apart = run("well", True, lambda t: None)
    np.testing.assert_array_equal(inside["bad.y"].values, apart["bad.y"].values)
    assert told[-1] == Fraction(1, 100)
    assert inside.timing is not None
    assert inside.timing.executor == executor
    errors = []
    for process in (False, True):
        with pytest.raises(SimulationError, match="motor is on fire") as caught:
            run("error", process, lambda t: None)
        errors.append(str(caught.value))
    assert errors[0] == errors[1]


SCENARIO = """
stop = "1/100"
[components.bad]
fmu = "misbehaves.fmu"
step = "1/1000"
isolation = "none"
parameters = { mode = %d, at = 0.005 }
[record]
"bad.y" = "1/1000"
[metrics]
y = { kind = "peak", of = "bad.y" }
[expect]
"y.value" = { below = -1.0 }
"""


def test_pytest_fails_although_the_fmu_exits_with_0(
    misbehaves: Path, tmp_path: Path
) -> None:
    fmu = tmp_path / "misbehaves.fmu"
    fmu.write_bytes(misbehaves.read_bytes())
    mode = MODES.index("exit")
    (tmp_path / "bad.toml").write_text(SCENARIO % mode)
    (tmp_path / "test_after.py").write_text("def test_after():\n    assert False\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert "the process of the run ended with exit code 7 during doStep" in done.stdout
    assert "2 failed" in done.stdout
