"""After every fault a command ends with the right words and code, and cleans up.

Every run here is to be judged by a metric of every kind: none masks its fault.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from broken import MISBEHAVES, MODES, pack
from every_metric import METRICS

from orchestrator.result import Result

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="looks for processes in /proc"
)


@pytest.fixture(scope="module")
def misbehaves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack("misbehaves", MISBEHAVES, tmp_path_factory.mktemp("broken"))


def default_interrupt() -> None:
    """Let SIGINT end the process as it does at a terminal."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Command:
    """``feeddrive run`` of a misbehaving FMU, with a temporary folder of its own."""

    def __init__(self, fmu: Path, place: Path) -> None:
        self.fmu, self.place = fmu, place
        self.temporary, self.folder = place / "temporary", place / "run"
        self.temporary.mkdir()

    def start(
        self,
        mode: str,
        *,
        at: float = 0.05,
        step: str = "1/1000",
        stop: float = 0.1,
        more: str = "",
        **options: Any,
    ) -> "subprocess.Popen[str]":
        # a test run in the background inherits that Ctrl-C is ignored
        options.setdefault("preexec_fn", default_interrupt)
        scenario = self.place / "scenario.toml"
        scenario.write_text(
            f"""
stop = {stop}
[components.bad]
fmu = "{self.fmu}"
step = "{step}"
parameters = {{ mode = {MODES.index(mode)}, at = {at} }}
{more}
[record]
"bad.y" = "1/1000"
"bad.u" = "1/1000"
{tomli_w.dumps({"metrics": METRICS})}
"""
        )
        command = [sys.executable, "-m", "orchestrator", "run", scenario.name]
        return subprocess.Popen(
            [*command, "-o", str(self.folder), "--overwrite"],
            cwd=self.place,
            env={**os.environ, "TMPDIR": str(self.temporary)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            **options,
        )

    def run(self, mode: str, **options: Any) -> tuple[int, str]:
        """Return the exit code and stderr on one line."""
        return self.end(self.start(mode, **options))

    def end(self, process: "subprocess.Popen[str]") -> tuple[int, str]:
        try:
            _, said = process.communicate(timeout=60)
        finally:
            process.kill()
        assert "Traceback" not in said
        return process.returncode, " ".join(said.split())

    def rows(self) -> int:
        return len(Result(self.folder)["bad.y"])

    def left(self) -> list[str]:
        """Return folders and processes that are still there."""
        wait_until(lambda: not self._processes(), 10)
        return [*(p.name for p in self.temporary.iterdir()), *self._processes()]

    def _processes(self) -> list[str]:
        mark = f"TMPDIR={self.temporary}".encode()
        found = []
        for place in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (place / "environ").read_bytes().split(b"\0"):
                    found.append((place / "cmdline").read_text())
            except OSError:
                continue
        return found


def wait_until(met: Callable[[], bool], within: float = 60) -> None:
    end = time.monotonic() + within
    while not met() and time.monotonic() < end:
        time.sleep(0.02)


@pytest.fixture
def command(misbehaves: Path, tmp_path: Path) -> Iterator[Command]:
    made = Command(misbehaves, tmp_path)
    yield made
    assert made.left() == []


APART, TOGETHER = 'isolation = "process"', 'isolation = "none"'


@pytest.mark.parametrize("isolation", [TOGETHER, APART])
@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("error", "doStep of 0.001 s at t = 0.05 s returned Error. The FMU logged: "),
        ("fatal", "doStep of 0.001 s at t = 0.05 s returned Fatal. The FMU logged: "),
        ("discard", "doStep of 0.001 s at t = 0.05 s returned Discard. The FMU logged"),
        ("nan", "y is nan at t = 0.051 s"),
    ],
)
def test_what_an_fmu_reports_ends_the_run(
    command: Command, mode: str, said: str, isolation: str
) -> None:
    code, error = command.run(mode, more=isolation)
    assert code == 1
    assert f"bad (misbehaves.fmu): {said}" in error
    assert command.rows() == 51


@pytest.mark.parametrize(
    ("mode", "more", "said"),
    [
        ("segfault", "", "its process ended with signal 11 (SIGSEGV) during doStep"),
        ("exit", APART, "its process ended with exit code 7 during doStep of 0.001 s"),
        ("hang", f'{APART}\nanswer_within = "1/2"', "no answer within 0.5 s"),
        (
            "memory",
            f'{APART}\nmemory_limit = "200 MB"',
            "its process ended with signal 6 (SIGABRT)",
        ),
    ],
)
def test_a_crash_of_an_isolated_fmu_ends_the_run_by_its_name(
    command: Command, mode: str, more: str, said: str
) -> None:
    code, error = command.run(mode, more=more)
    assert code == 1
    assert f"bad (misbehaves.fmu): {said}" in error
    assert command.rows() == 51


@pytest.mark.parametrize("isolation", [TOGETHER, APART])
def test_a_thread_that_an_fmu_leaves_does_not_hinder_the_end(
    command: Command, isolation: str
) -> None:
    code, error = command.run("thread", more=isolation)
    assert (code, error) == (0, "")
    assert command.rows() == 101


@pytest.mark.parametrize(
    ("mode", "how"), [("segfault", "signal 11 (SIGSEGV)"), ("exit", "exit code 7")]
)
def test_a_crash_without_isolation_is_that_of_a_child_and_leaves_its_rows(
    command: Command, mode: str, how: str
) -> None:
    code, error = command.run(mode, at=60, stop=70, step="1/50000", more=TOGETHER)
    assert code == 1
    text = f"bad (misbehaves.fmu): the process of the run ended with {how} during doSt"
    assert text in error
    assert 0 < command.rows() <= 60_001


def test_an_fmu_for_other_platforms_is_refused_as_usage(
    misbehaves: Path, tmp_path: Path
) -> None:
    foreign = pack("misbehaves", MISBEHAVES, tmp_path, host="win64")
    command = Command(foreign, tmp_path)
    for more in (TOGETHER, APART):
        code, error = command.run("well", more=more)
        assert code == 2
        assert "has no binary for this machine (binaries/linux64/" in error
        assert "it has: win64" in error
    assert command.left() == []


@pytest.mark.parametrize("isolation", [TOGETHER, APART])
def test_ctrl_c_ends_the_run_with_130_and_keeps_the_rows(
    command: Command, isolation: str
) -> None:
    process = begun(command, "well", isolation)
    process.send_signal(signal.SIGINT)
    code, error = command.end(process)
    assert code == 130
    assert "interrupted" in error
    assert command.rows() > 0


def test_ctrl_c_reaches_a_run_that_waits_for_a_hanging_fmu(command: Command) -> None:
    process = begun(command, "hang", APART, at=1e3)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert command.end(process)[0] == 130


@pytest.mark.parametrize("mode", ["well", "hang"])
def test_nothing_outlives_a_killed_run_but_folders_that_the_next_run_deletes(
    command: Command, mode: str
) -> None:
    process = begun(command, mode, APART, at=1e3)
    process.kill()
    process.communicate()
    assert command.left() == []
    assert command.rows() > 0


def test_a_full_disk_ends_the_run_and_keeps_the_rows(command: Command) -> None:
    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))

    code, error = command.run("well", stop=100, more=TOGETHER, preexec_fn=limited)
    assert code == 1
    assert (
        "rows cannot be written ([Errno 27] File too large); free some space" in error
    )
    assert 0 < command.rows() < 20_000
    shutil.rmtree(command.folder)


def begun(
    command: Command, mode: str, more: str, at: float = 1e9
) -> "subprocess.Popen[str]":
    """Start an endless run and return it when it has written rows."""
    process = command.start(mode, at=at, stop=1e5, step="1/1000", more=more)
    result = command.folder / "result"
    wait_until(lambda: sum(f.stat().st_size for f in result.glob("*.arrows")) > 5000)
    return process
