"""Every run has a folder of its own, and says afterwards what became of it."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import Interrupted, ScenarioError, SimulationError
from orchestrator.folders.held import FolderHeld, held, is_held
from orchestrator.history.folder import RUNS, Begun, taken
from orchestrator.history.listing import entries, find, remove
from orchestrator.result import Result

SNAP = """
stop = "0.02"
[components.snap]
fmu = "plants.disturbances.rope_snap"
parameters = { t_0 = 0 }
[record]
"snap.d_2" = "20 kHz"
[metrics]
force = { kind = "peak", of = "snap.d_2" }
"""
STUDY = "ball_screw_pole_placement"
ENDLESS = ["--set", "stop=1e4", "--set", "snap.step=1/1000"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "snap.toml").write_text(SNAP)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


def feeddrive(*arguments: str):
    return CliRunner().invoke(app, arguments)


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "orchestrator", *arguments]


def test_twelve_runs_at_once_give_twelve_right_results(here: Path) -> None:
    assert feeddrive("run", "snap.toml", "-o", "first").exit_code == 0  # builds
    sizes = [round(0.1 * n, 1) for n in range(1, 13)]

    def ran(size: float) -> dict:
        given = command("run", "snap.toml", "--json", "--set", f"snap.d_0={size}")
        done = subprocess.run(given, cwd=here, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    with ThreadPoolExecutor(len(sizes)) as pool:
        printed = list(pool.map(ran, sizes))
    assert sorted(p["number"] for p in printed) == list(range(1, 13))
    listed = {e.name: e for e in entries(RUNS)}
    for size, one in zip(sizes, printed, strict=True):
        entry = listed[f"snap/{one['number']}"]
        assert (entry.state, entry.changed) == ("complete", (f"snap.d_0={size}",))
        written = json.loads(Path(one["result"], "metrics.json").read_text())
        told = (one, entry.summary, written)
        assert {t["metrics"]["force.peak"]["value"] for t in told} == {size}
        assert max(Result(entry.folder)["snap.d_2"].values) == size


def test_a_named_folder_is_taken_by_one_of_two_at_once(here: Path) -> None:
    given = command("run", "snap.toml", *ENDLESS, "-o", "out")
    first = subprocess.Popen(given, cwd=here, stderr=subprocess.PIPE, text=True)
    until(lambda: is_held(here / "out") if (here / "out").is_dir() else False)
    second = feeddrive("run", "snap.toml", "-o", "out", "--overwrite")
    assert second.exit_code == 2
    assert "out: another run is writing there; give another folder" in second.stderr
    first.kill()
    first.communicate()
    third = feeddrive("run", "snap.toml", "-o", "out")
    assert third.exit_code == 2
    assert "out: holds a run already" in third.stderr
    assert feeddrive("run", "snap.toml", "-o", "out", "--overwrite").exit_code == 0


def until(met) -> None:
    end = time.monotonic() + 60
    while not met():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_runs_says_what_is_under_way_interrupted_and_killed(here: Path) -> None:
    begun = [
        subprocess.Popen(
            command("run", "snap.toml", *ENDLESS),
            cwd=here,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        for _ in range(2)
    ]
    until(lambda: len([e for e in entries(RUNS) if e.reached]) == 2)
    assert {e.state for e in entries(RUNS)} == {"under way"}
    assert all(len(Result(e.folder)["snap.d_2"]) > 1 for e in entries(RUNS))
    assert feeddrive("runs", "--remove", "1").exit_code == 2
    for process, how in zip(begun, (signal.SIGINT, signal.SIGKILL), strict=True):
        process.send_signal(how)
        process.wait()
    states = {e.state for e in entries(RUNS)}
    assert states == {"interrupted", "killed"}
    for entry in entries(RUNS):
        assert 0 < entry.reached < entry.stop == 1e4
        rows = Result(entry.folder)["snap.d_2"]
        assert rows.time[-1] == entry.reached
    shown = feeddrive("runs").stdout
    assert "interrupted at" in shown
    assert "killed at" in shown
    assert "stop=1e4, snap.step=1/1000" in shown


def test_a_failed_run_keeps_its_first_error_and_its_rows(here: Path) -> None:
    error = ended(SimulationError("too hot"), BEGUN, rows=True)
    (entry,) = entries(RUNS)
    assert (entry.state, entry.why, entry.reached) == ("failed", "too hot", 0.02)
    assert error.folder == entry.folder


def test_an_error_says_where_rows_are_and_a_refusal_leaves_no_folder(
    here: Path,
) -> None:
    assert ended(SimulationError("too hot"), BEGUN).folder is None
    stopped = ended(KeyboardInterrupt(), BEGUN, rows=True)
    assert isinstance(stopped, Interrupted)
    assert str(stopped) == (
        "interrupted at t = 0.02 s; the rows until then are in runs/snap/2/result"
    )
    assert stopped.folder == Path("runs/snap/2")
    ended(ScenarioError("wrong"), Begun("run", "other/one"))
    assert not Path("runs/other").exists()


def test_an_interrupted_member_interrupts_its_comparison(here: Path) -> None:
    def begun() -> None:
        with (
            taken(None, Begun("demo", "demo")) as place,
            taken(place.path / "one", BEGUN) as member,
        ):
            rows_of(member.path)
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="demo/1/one/result"):
        begun()
    assert [e.state for e in entries(RUNS)] == ["interrupted"]


def ended(error: BaseException, begun: Begun, *, rows: bool = False):
    """Return what leaves the folder of a run that an error ends."""

    def fail() -> None:
        with taken(None, begun) as place:
            if rows:
                rows_of(place.path)
            raise error

    with pytest.raises((type(error), Interrupted)) as left:
        fail()
    return left.value


def test_runs_keeps_the_newest_and_removes_only_what_it_is_told_to(here: Path) -> None:
    for name in ("snap", "snap", "a/b"):
        with taken(None, Begun("run", name)) as place:
            place.complete({"metrics": {}})
    (here / "runs/notes.txt").write_text("mine")
    assert [e.name for e in entries(RUNS)] == ["snap/1", "snap/2", "a/b/1"]
    with pytest.raises(ScenarioError, match=r"snap/1, a/b/1; write more"):
        find("1", entries(RUNS))
    assert feeddrive("runs", "b", "--remove", "1").exit_code == 0
    printed = json.loads(feeddrive("runs", "--keep", "1", "--json").stdout)
    assert printed["removed"] == ["snap/1"]
    assert [e["name"] for e in printed["runs"]] == ["snap/2"]
    assert (here / "runs/notes.txt").is_file()
    assert "no runs of elsewhere" in feeddrive("runs", "elsewhere").stdout


def test_members_of_a_comparison_are_no_entries(here: Path) -> None:
    with taken(None, Begun("demo", "demo")) as place:
        for name in ("one", "other"):
            with taken(place.path / name, BEGUN) as member:
                member.complete({"metrics": {}})
        place.complete({"runs": []})
    assert [(e.name, e.kind) for e in entries(RUNS)] == [("demo/1", "demo")]


def test_demo_and_reproduce_are_one_entry_each(here: Path) -> None:
    assert feeddrive("demo", "--json").exit_code == 0
    only = ("--only", "mc_ppc.track_200.peak")
    assert feeddrive("reproduce", STUDY, *only, "--json").exit_code == 0
    found = {e.name: e for e in entries(RUNS)}
    assert set(found) == {"demo/1", f"{STUDY}/reproduce/1"}
    assert {e.state for e in found.values()} == {"complete"}
    shown = feeddrive("runs").stdout
    assert "tracking.peak 2.4903 um" in " ".join(shown.split())
    assert "--only mc_ppc.track_200.peak" in shown


def test_a_folder_that_is_held_is_not_removed(here: Path) -> None:
    with taken(None, BEGUN) as place:
        with pytest.raises(ScenarioError, match="snap/1 is under way"):
            remove(entries(RUNS))
        with pytest.raises(FolderHeld), held(place.path):
            pass
    assert not is_held(place.path)


BEGUN = Begun("run", "snap", (), 0.02)


def rows_of(folder: Path) -> None:
    """Record a run of 20 ms in a folder."""
    done = feeddrive("run", "snap.toml", "-o", "aside", "--overwrite")
    assert done.exit_code == 0
    Path("aside/result").rename(folder / "result")
