"""An FMU that attacks its host ends by name and within its time, and leaves nothing."""

import os
import pickle
import signal
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hostile import hostile_fmu, left_running
from systems import system

from orchestrator.errors import SimulationError
from orchestrator.instances.descendants import MARK
from orchestrator.instances.frames import Damaged, decode, encode
from orchestrator.instances.guard import guards
from orchestrator.instances.logs import LogMessage
from orchestrator.master.simulate import Choice, simulate
from orchestrator.result import Result
from orchestrator.system import Component, Isolation
from orchestrator.warned import collecting

pytestmark = pytest.mark.skipif(
    not guards(), reason="the hostile FMU, its traces and its guard are of Linux"
)
EXECUTORS: list[Choice] = ["kernel", "python"]
WITHIN = 2.0  # s, answer_within
ENDLESS = 600  # s; a loaded machine takes a minute to start some processes


def hostile(folder: Path, how: str, apart: bool = True) -> Component:
    fmu = hostile_fmu(how, folder)
    isolation = Isolation(process=apart, answer_within=WITHIN)
    return Component("bad", fmu, Fraction(1, 1000), isolation=isolation)


def run(
    folder: Path, how: str, executor: Choice = "kernel", apart: bool = True
) -> Result:
    bad = hostile(folder, how, apart)
    whole = system("1/100", [bad], record={"bad.y": "1/1000"})
    return simulate(whole, folder / "run", executor=executor)


@pytest.fixture(autouse=True)
def nothing_is_left() -> Iterator[None]:
    signal.signal(signal.SIGALRM, late)
    signal.alarm(ENDLESS)
    yield
    signal.alarm(0)
    assert left_running(f"{MARK}={os.getpid()}-") == []


def late(*_: object) -> None:
    raise AssertionError(f"did not end within {ENDLESS} s: what hangs, hangs for ever")


def assert_whole(result: Result) -> None:
    expected = [0.0, *(k / 1000 for k in range(1, 11))]
    np.testing.assert_allclose(result["bad.y"].values, expected, atol=1e-15)


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("how", ["writes", "closes", "forges"])
def test_what_spoils_its_descriptors_is_named_and_its_rows_are_right(
    tmp_path: Path, how: str, executor: Choice
) -> None:
    """By an error if it is seen while the run goes on, by a warning at its end."""
    with collecting() as told:
        try:
            run(tmp_path, how, executor)
        except SimulationError as error:
            told.append(str(error))
    assert told[0].startswith("bad (hostile2.fmu): its process ")
    kept = Result(tmp_path / "run")["bad.y"].values
    assert 2 <= len(kept) <= 11
    np.testing.assert_allclose(kept, np.arange(len(kept)) / 1000, atol=1e-15)


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("how", ["well", "cuts", "daemon", "unmarked"])
def test_shared_memory_cannot_be_cut_and_daemons_end_with_the_run(
    tmp_path: Path, how: str, executor: Choice
) -> None:
    with collecting() as warnings:
        assert_whole(run(tmp_path, how, executor))
    assert warnings == []


def test_a_constructor_without_end_is_named(tmp_path: Path) -> None:
    text = r"no answer within 5 s \(answer_within\) in load; its process is killed"
    with pytest.raises(SimulationError, match=text):
        run(tmp_path, "constructor")


def test_what_it_prints_and_logs_steers_no_terminal(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    assert_whole(run(tmp_path, "logs"))
    printed = capfd.readouterr().err
    assert "\\x1b[2Jprinted\n" in printed
    assert "\\x1b]0;evil\\x07\\x1b[2J" in caplog.text
    assert "\x1b" not in printed + caplog.text


def test_where_the_system_forbids_what_guards_need_there_are_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def forbidden(_: int) -> int:
        raise PermissionError(1, "pidfd_open")

    monkeypatch.setattr(os, "pidfd_open", forbidden)
    guards.cache_clear()
    assert not guards()
    monkeypatch.undo()
    guards.cache_clear()


def test_one_that_stops_itself_is_late(tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match=r"no answer within 2 s .* in doStep"):
        run(tmp_path, "stops")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("hang", r"no answer within 2 s \(answer_within\) in doStep; the process of"),
        ("stops", r"no answer within 2 s \(answer_within\) in doStep; the process of"),
        ("constructor", r"no answer within 2 s \(answer_within\) in load; the proc"),
        ("exit 0", "the process of the run ended with exit code 0 during doStep"),
        (
            "exit 0 in constructor",
            "the process of the run ended with exit code 0 during",
        ),
    ],
)
def test_let_into_the_run_it_ends_within_its_time_and_by_name(
    tmp_path: Path, how: str, said: str
) -> None:
    with pytest.raises(SimulationError, match=rf"^bad \(hostile2.fmu\): {said}"):
        run(tmp_path, how, apart=False)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("crash in terminate", "ended with signal 11 (SIGSEGV)"),
        ("crash in free", "ended with signal 11 (SIGSEGV)"),
        ("hang in free", "did not end and is killed"),
    ],
)
def test_let_into_the_run_its_end_is_warned_of_and_the_rows_are_fine(
    tmp_path: Path, how: str, said: str
) -> None:
    with collecting() as warnings:
        assert_whole(run(tmp_path, how, apart=False))
    (warning,) = warnings
    assert warning == (
        f"bad: the process of the run {said} in terminate and free; the rows are "
        f"complete"
    )


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (
            "crash in terminate",
            "its process ended with signal 11 (SIGSEGV) when",
        ),
        ("crash in free", "its process ended with signal 11 (SIGSEGV) when"),
        ("hang in terminate", "its process did not end within 2 s and is killed when"),
    ],
)
def test_what_does_not_survive_its_end_is_warned_of_and_the_rows_are_fine(
    tmp_path: Path, how: str, said: str
) -> None:
    with collecting() as warnings:
        assert_whole(run(tmp_path, how))
    (warning,) = warnings
    assert warning.startswith(f"bad (hostile2.fmu): {said}")
    assert warning.endswith("what was recorded is complete")


@pytest.mark.parametrize("how", ["beyond", "before"])
def test_what_writes_beside_its_values_crashes_where_it_does(
    tmp_path: Path, how: str
) -> None:
    with pytest.raises(SimulationError, match=r"SIGSEGV\) during get"):
        run(tmp_path, how)


class Spoon:
    """What a pickle would carry out."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.system, ("touch /tmp/feeddrive-escaped",)


@pytest.mark.parametrize(
    "data",
    [
        pickle.dumps(("done", Spoon())),
        b"",
        b"\xff",
        b"[" * 100_000,
        b'["done"]',
        b'["done", "text"]',
        b'["done", [1, [2]]]',
        b'["done", [{"hex": "0g"}]]',
        b'["nothing", null]',
        b'["error", {"error": "SystemExit", "text": "x"}]',
        b'["error", {"by": "x", "at": "soon", "reason": "x"}]',
        b'["log", {"status": "OK"}]',
        b'{"done": null}',
        b"null",
    ],
)
def test_what_is_no_frame_is_not_believed(data: bytes) -> None:
    with pytest.raises(Damaged):
        decode(data)
    assert not Path("/tmp/feeddrive-escaped").exists()


def test_frames_carry_what_they_are_given() -> None:
    values = [1.5, -0.0, 2**63 + 1, float("inf"), 5e-324, True, "a b", b"\0\xff"]
    assert decode(encode("done", values)) == ("done", values)
    message = LogMessage("Error", "motor", "it's \x1b[2J on fire", 0.25)
    assert decode(encode("log", message)) == ("log", message)
    kind, error = decode(encode("error", SimulationError("broken")))
    assert (kind, type(error), str(error)) == ("error", SimulationError, "broken")
