"""A sweep that is broken into: by a crash, from outside, by Ctrl-C; and goes on."""

import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from broken import MISBEHAVES, MODES, pack
from typer.testing import CliRunner

from orchestrator.analysis.kept import MEMBERS, SWEEP
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Axis, parse_axis
from orchestrator.cli import app
from orchestrator.errors import ScenarioError

DRIVE = Path(__file__).parents[3] / "docs" / "examples" / "does_it_hold" / "drive.toml"
SHORT = ["stop=0.05"]
HELD = """
base = "ball_screw_pole_placement/mc_ppc_track_500"
[expect]
"tracking.peak" = { below = 4, unit = "um" }
"""


def nominal(_: str) -> float:
    return 2.0


BREAKING = """
stop = "1/100"
[components.source]
fmu = "controllers.references.stair"
step = "1/1000"
[components.alien]
fmu = "{fmu}"
step = "1/1000"
parameters = {{ mode = {mode} }}
[connections]
"alien.u" = "source.x_r"
[record]
"alien.y" = true
[metrics]
y = {{ kind = "peak", of = "alien.y" }}
"""


def breaking(mode: str, folder: Path) -> Path:
    file, fmu = folder / "breaking.toml", pack("misbehaves", MISBEHAVES, folder)
    file.write_text(BREAKING.format(fmu=fmu, mode=MODES.index(mode)))
    return file


def test_a_member_that_crashes_its_fmu_is_named_and_no_other_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = breaking("segfault", tmp_path)
    command = ["sweep", str(file), "--vary", "alien.at=1,0.005,2,3,4", "--json"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 1, done.output
    told = json.loads(done.stdout)
    assert (told["members"], told["failed"]) == (5, 1)
    assert "1 of 5 members failed" in done.stderr
    first, second, *others = pq.read_table(told["figures"]).to_pylist()
    assert "SIGSEGV" in second["failure"]
    for row in (first, *others):
        assert row["failure"] is None
        assert row["y.peak"] == first["y.peak"] > 0


def test_processes_killed_from_outside_are_replaced(tmp_path: Path) -> None:
    file, axes = breaking("well", tmp_path), [Axis("alien.at", tuple(range(1, 7)))]
    killed = []

    def kill(done: int) -> None:
        if done == 2:
            for child in multiprocessing.active_children():
                child.kill()
                killed.append(child.pid)

    found = sweep(file, axes, progress=kill)
    assert killed
    assert [row["failure"] for row in found.rows] == [None] * 6
    assert {row["y.peak"] for row in found.rows} == {found.rows[0]["y.peak"]}


PRESSED = """
import os, signal
from orchestrator.analysis import sweep
from orchestrator.cli import app

written, add = [], sweep._Lines.add

def pressed(lines, row):
    add(lines, row)
    written.append(row)
    if len(written) == 3:
        os.kill(os.getpid(), signal.SIGINT)

sweep._Lines.add = pressed
app()
"""


def test_ctrl_c_loses_nothing_and_resume_does_the_rest(tmp_path: Path) -> None:
    """The key is pressed when three of 31 members are written."""
    given = ["sweep", str(DRIVE), "--vary", "plant.m_2=3.5e-4:4e-4:31"]
    ours = {"PYTHONPATH": str(Path(__file__).parents[3])}
    begun = subprocess.run(
        [sys.executable, "-c", PRESSED, *given],
        cwd=tmp_path,
        env=os.environ | ours,
        capture_output=True,
        check=False,
    )
    assert begun.returncode == 130, begun.stderr
    (first,) = tmp_path.glob("runs/*/*/members.jsonl")
    lines = first.read_text().splitlines()
    assert len(lines) == 3
    command = [sys.executable, "-m", "orchestrator", *given]
    again = subprocess.run(
        [*command, "--resume", "--json"],
        cwd=tmp_path,
        env=os.environ | ours,
        capture_output=True,
        check=True,
    )
    told = json.loads(again.stdout)
    assert told["members"] == 31
    kept = (Path(tmp_path, told["result"]) / MEMBERS).read_text().splitlines()
    assert kept[: len(lines)] == lines
    whole = sweep(DRIVE, [parse_axis("plant.m_2=3.5e-4:4e-4:31", nominal)])
    table = pq.read_table(tmp_path / told["figures"]).to_pylist()
    assert [row["tracking.peak"] for row in table] == [
        row["tracking.peak"] for row in whole.rows
    ]


def test_an_interrupted_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    axes = [Axis("plant.m_2", (3e-4, 3.5e-4, 4e-4))]
    whole = sweep(DRIVE, axes, sets=SHORT, folder=tmp_path)
    lines = (tmp_path / MEMBERS).read_text().splitlines()
    (tmp_path / MEMBERS).write_text(lines[0] + "\n" + lines[1][:20])
    again = sweep(DRIVE, axes, sets=SHORT, folder=tmp_path)
    assert again.rows == whole.rows
    with pytest.raises(ScenarioError, match="another sweep"):
        sweep(DRIVE, [Axis("plant.k", (200.0,))], sets=SHORT, folder=tmp_path)


TWO = ["--vary", "plant.m_2=3e-4,4e-4", "--set", "stop=0.05"]


@pytest.mark.parametrize(
    ("more", "old", "new", "said"),
    [
        (["--set", "plant.k=50"], "", "", "plant.k=50"),
        (["--vary", "plant.b_1=0.001"], "", "", "they vary plant.m_2, this one"),
        ([], "below = 4", "below = 1", "the scenario has changed"),
        ([], 'unit = "um"', 'unit = "mm"', "the scenario has changed"),
    ],
    ids=["set", "axis", "expectation", "unit"],
)
def test_a_sweep_of_something_else_is_not_gone_on_with(
    more: list[str],
    old: str,
    new: str,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("drive.toml")
    file.write_text(HELD)
    assert CliRunner().invoke(app, ["sweep", str(file), *TWO]).exit_code == 0
    file.write_text(HELD.replace(old, new))
    refused = CliRunner().invoke(app, ["sweep", str(file), *TWO, *more, "--resume"])
    assert refused.exit_code == 2, refused.output
    assert "runs/drive/1: holds members of another sweep" in refused.stderr
    assert said in refused.stderr
    assert not Path("runs/drive/2").exists()


def test_a_member_of_one_value_more_is_none_of_a_sweep_without_it(
    tmp_path: Path,
) -> None:
    masses = Axis("plant.m_2", (3e-4,))
    sweep(DRIVE, [masses, Axis("plant.k", (50.0,))], sets=SHORT, folder=tmp_path)
    with pytest.raises(ScenarioError, match=r"plant\.k"):
        sweep(DRIVE, [masses], sets=SHORT, folder=tmp_path)
    (tmp_path / SWEEP).unlink()
    with pytest.raises(ScenarioError, match="nobody knows"):
        sweep(DRIVE, [masses], sets=SHORT, folder=tmp_path)


def test_a_sweep_gone_on_with_shows_its_figures_with_units(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["sweep", str(DRIVE), *TWO]
    assert CliRunner().invoke(app, asked).exit_code == 0
    again = CliRunner().invoke(app, [*asked, "--resume", "--json"])
    assert again.exit_code == 0, again.output
    told = json.loads(again.stdout)
    assert told["executor"] == ""  # all done before
    schema = pq.read_table(told["figures"]).schema
    assert schema.field("tracking.peak").metadata[b"unit"] == b"um"
