"""A run killed at any moment and resumed has the rows of one that was not, to the bit.

One kill in the plain suite, 50 with ``--hostile``; some arrive while a checkpoint is
written, or before the first.
"""

import json
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from draws import drawn

from orchestrator.result import Result
from orchestrator.session import run

HERE = Path(__file__).parent
MODELS = HERE.parent / "fmus" / "small_models"
KILLS = 50
SCENARIO = """
stop = "10"
[components.noise]
fmu = "plants.disturbances.noise"
step = "1/500"
parameters = { sigma = 1.0 }
map = { d = { name = "d", gain = 1.0, unit = "rad/s" } }
[components.pi]
fmu = "pi.py"
step = "1/1000"
latency = 2
[components.late]
fmu = "late.py"
step = "1/2000"
[components.late.map]
u = { name = "u", gain = 2.0, unit = "N.m" }
y = { name = "y", gain = 1.0, unit = "rad/s" }
[components.slow]
fmu = "pi.py"
step = "1/400"
offset = "1/3000"
isolation = "process"
[connections]
"pi.r" = "noise.d"
"late.u" = "pi.u"
"pi.y" = "late.y"
"slow.y" = "late.y"
[faults]
"pi.y" = { kind = "delay", samples = 3, window = ["1", "8"] }
"slow.y" = { kind = "stuck", window = ["1/2", "9"] }
"late.u" = { kind = "bias", value = 0.01, window = ["5.0003", "10"] }
[record]
"late.y" = "1/2000"
"pi.u" = "1/1000"
"slow.u" = "1/400"
"pi.y" = "1/1000"
[metrics]
u = { kind = "max", of = "late.y" }
"""


@dataclass(frozen=True)
class Known:
    """A project, what a whole run recorded and found there, how long one takes (s)."""

    project: Path
    rows: Result
    metrics: object
    took: float


def begin(project: Path, *words: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "orchestrator", *words],
        cwd=project,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: "subprocess.Popen[str]") -> tuple[int, str, str]:
    out, err = process.communicate(timeout=600)
    return process.returncode, out, err


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Known:
    project = tmp_path_factory.mktemp("resumed")
    for model in ("pi.py", "late.py"):
        shutil.copyfile(MODELS / model, project / model)
    (project / "pyproject.toml").touch()
    (project / "s.toml").write_text(SCENARIO)
    run(project / "s.toml", project / "whole", report=False)
    begun = time.monotonic()
    code, out, err = ended(
        begin(project, "run", "s.toml", "-o", "saved", "--checkpoint", "1/4", "--json")
    )
    assert code == 0, err
    took = time.monotonic() - begun
    whole = Result(project / "whole")
    assert_same(Result(project / "saved"), whole)
    assert not (project / "saved" / "checkpoint").exists()
    return Known(project, whole, json.loads(out)["metrics"], took)


def assert_same(found: Result, whole: Result) -> None:
    assert list(found) == list(whole)
    for name, signal_ in whole.items():
        for one, other in (
            (found[name].time, signal_.time),
            (found[name].values, signal_.values),
        ):
            np.testing.assert_array_equal(one.view(np.int64), other.view(np.int64))


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(n, marks=[pytest.mark.sample] if n == 0 else [])
        for n in range(KILLS)
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_a_run_that_is_killed_and_resumed_has_the_same_bits(
    number: int, known: Known
) -> None:
    draw, folder = drawn(f"kill {number}"), f"killed-{number}"
    anew = "run", "s.toml", "-o", folder, "--checkpoint", "1/4"
    words, kills = anew, 1 + number % 2
    for _ in range(kills):  # some are killed again when they are resumed
        process = begin(known.project, *words)
        time.sleep(known.took * draw.uniform(0.3, 1.0))
        process.send_signal(signal.SIGKILL)
        ended(process)
        if (known.project / folder / "scenario.lock.toml").is_file():
            words = ("resume", folder)
    complete = (known.project / folder / "metrics.json").is_file()
    if complete:  # it was quicker
        assert_same(Result(known.project / folder), known.rows)
        return
    if words == anew:
        words = (*anew, "--overwrite")
    code, out, err = ended(begin(known.project, *words, "--json"))
    assert code == 0, err
    assert json.loads(out)["metrics"] == known.metrics
    assert_same(Result(known.project / folder), known.rows)
    assert not (known.project / folder / "checkpoint").exists()
    shutil.rmtree(known.project / folder)
