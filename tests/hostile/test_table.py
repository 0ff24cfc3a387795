"""What a hostile FMU does x metric x isolation x executor, through the command.

Each case asserts exit code, words, rows, that nothing is left behind, and that the
command ends by itself.  The metric of a case is drawn; every kind occurs.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
import tomli_w
from draws import drawn
from every_metric import METRICS
from hostile import HOW, hostile_fmu, left_running

from orchestrator.instances.guard import guards

pytestmark = pytest.mark.skipif(
    not guards(), reason="the hostile FMU, its traces and its guard are of Linux"
)
WITHIN = 3  # s, answer_within
ENDLESS = 300  # s for a command that would otherwise hang; loaded machines are slow
FINE: tuple[int, ...] = (0,)
FAILED: tuple[int, ...] = (1,)
EITHER = (0, 1)
LATE = f"no answer within {WITHIN} s (answer_within) in doStep"
SEGV, ABORT = "signal 11 (SIGSEGV)", "signal 6 (SIGABRT)"


@dataclass(frozen=True)
class Expected:
    """Exit codes and words on stderr: apart, and let into the run."""

    apart: tuple[int, ...]
    said: str = ""
    inside: tuple[int, ...] | None = None
    said_inside: str = ""


# let in, whatever spoils the process of the run may spoil its rows: it must say so
EXPECTED = {
    "well": Expected(FINE),
    "writes": Expected(EITHER, "its process", EITHER),
    "closes": Expected(EITHER, "its process", EITHER),
    "cuts": Expected(FINE, "", EITHER),
    "daemon": Expected(FINE),
    "unmarked": Expected(FINE),
    "constructor": Expected(FAILED, "(answer_within) in load", FAILED, "in load"),
    "crash in terminate": Expected(FINE, SEGV),
    "crash in free": Expected(FINE, SEGV),
    "hang in terminate": Expected(FINE, "is killed when", FINE, "is killed in term"),
    "hang in free": Expected(FINE, "is killed when", FINE, "is killed in term"),
    "beyond": Expected(FAILED, f"{SEGV} during get", EITHER),
    "before": Expected(FAILED, f"{SEGV} during get", EITHER),
    "stops": Expected(FAILED, "no answer within", FAILED, LATE),
    "hang": Expected(FAILED, "no answer within", FAILED, LATE),
    "forges": Expected(EITHER, "its process", EITHER),
    "exit 0": Expected(FAILED, "exit code 0 during doStep"),
    "exit 0 in constructor": Expected(FAILED, "exit code 0 during load"),
    "crash": Expected(FAILED, f"{SEGV} during doStep"),
    "aborts": Expected(FAILED, f"{ABORT} during doStep"),
    "not a number": Expected(FAILED, "y is nan at t = 0.003 s"),
    "returns error": Expected(FAILED, "at t = 0.002 s returned Error"),
    "logs": Expected(FINE, "\\x1b[2J"),
    "escapes": Expected(FINE, "", EITHER),
}
SAMPLE = {("exit 0", "none", "kernel"), ("crash", "process", "python")}
CASES = [
    pytest.param(
        *case, marks=[pytest.mark.sample] if case in SAMPLE else [], id=" - ".join(case)
    )
    for how in HOW
    for isolation in ("process", "sandbox", "none")
    for executor in ("kernel", "python", "fused")
    for case in [(how, isolation, executor)]
]


@pytest.fixture(scope="session")
def metrics() -> dict[tuple[str, str, str], str]:
    """Return the kind of metric of every case; each kind has its turn."""
    kinds, order = sorted(METRICS), drawn("metrics")
    order.shuffle(kinds)
    return {
        case.values: kinds[number % len(kinds)]  # type: ignore[misc]
        for number, case in enumerate(CASES)
    }


def scenario(folder: Path, how: str, isolation: str, metric: str) -> Path:
    fmu = hostile_fmu(how, folder)
    table = {
        "stop": "1/100",
        "components": {
            "bad": {
                "fmu": fmu.name,
                "step": "1/1000",
                "isolation": isolation,
                "answer_within": WITHIN,
            },
            "ours": {"fmu": "controllers.ball_screw.p_pi", "step": "1/1000"},
        },
        "connections": {"ours.x_r": "bad.y"},
        "record": {"bad.y": "1/1000", "bad.u": "1/1000"},
        "metrics": {"it": METRICS[metric]},
    }
    file = folder / "s.toml"
    file.write_text(tomli_w.dumps(table))
    return file


def command(
    words: list[str], folder: Path, environment: dict[str, str]
) -> "subprocess.CompletedProcess[str]":
    """Start a command as users do."""
    return subprocess.run(
        [sys.executable, "-m", "orchestrator", *words],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=ENDLESS,
        check=False,
    )


@pytest.mark.parametrize(("how", "isolation", "executor"), CASES)
def test_whatever_it_does_the_command_says_so_ends_and_leaves_nothing(
    how: str,
    isolation: str,
    executor: str,
    metrics: dict[tuple[str, str, str], str],
    request: pytest.FixtureRequest,
    tmp_path: Path,
) -> None:
    metric = metrics[how, isolation, executor]
    file = scenario(tmp_path, how, isolation, metric)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    mark = f"{os.getpid()}-{tmp_path.name}"
    words = ["run", file.name, "--json", "-o", "run", "--executor", executor]
    environment = {"TMPDIR": str(temporary), "HOSTILE": mark}
    if (how, isolation, executor) in SAMPLE:
        done = command(words, tmp_path, environment)
    else:  # its imports are most of a command
        done = request.getfixturevalue("forker").run(words, tmp_path, environment)
    said = " ".join(done.stderr.replace("\n", " ").split())
    told = json.loads(done.stdout)
    expected = EXPECTED[how]
    apart = isolation != "none"
    inside = expected.apart if expected.inside is None else expected.inside
    told_of = expected.said if apart else expected.said_inside or expected.said
    codes = expected.apart if apart else inside
    assert done.returncode in codes, (metric, said)
    assert "a fault in feeddrive" not in said
    assert "Traceback" not in said
    assert "\x1b" not in said
    if expected.inside is None or apart or expected.said_inside:
        assert told_of in said, metric
    if done.returncode == 0:
        assert told["metrics"]
        assert (tmp_path / "run" / "metrics.json").is_file()
    else:
        assert "bad" in told["error"] or "row" in told["error"]
        assert not (tmp_path / "run" / "metrics.json").exists()
    assert left_running(f"HOSTILE={mark}") == []
    assert list(temporary.glob("feeddrive-run-*")) == []
