"""The command: what it prints, and where."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from command import DRIVE, TRACK, refused

from fmus.build import build


def test_run_prints_one_json_object_and_nothing_else_on_stdout(feeddrive, drive):
    result = feeddrive("run", drive, "--json", "-o", "out", "--set", "source.t_0=0")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    assert printed["scenario"] == "drive"
    assert printed["stop"] == 0.01
    assert printed["metrics"]["x.peak"]["unit"] == "deg"
    assert set(printed["timing"]) == {"wall_s", "real_time_factor", "us_per_instant"}
    assert Path(printed["result"], "report.html").is_file()


def test_run_prints_figures_with_units_and_where_they_are(feeddrive, drive):
    result = feeddrive("run", drive, "--fmi", "3")
    assert result.exit_code == 0, result.output
    assert "x.peak" in result.stdout
    assert "deg" in result.stdout
    assert Path("runs/drive/1/scenario.lock.toml").is_file()


def test_an_expectation_that_is_not_met_fails_the_run_as_written(feeddrive, drive):
    drive.write_text(DRIVE + '[expect]\n"x.peak" = { above = 1e6 }\n')
    result = feeddrive("run", drive)
    assert result.exit_code == 1
    assert "expectation not met: x.peak" in result.stderr
    assert feeddrive("run", drive, "--set", "stop=0.005").exit_code == 0


THEIRS = '''"""Somebody else's drive: other names, other units, counted backwards."""
from typing import Annotated, NamedTuple
from fmus.model import Continuous, Var
from plants.ball_screw.two_mass import Parameters, State, derivative
from plants.ball_screw import two_mass as ball_screw
class Input(NamedTuple):
    pull: Annotated[float, Var("mV", "pull on the table, towards them")] = 0.0
class Output(NamedTuple):
    angle: Annotated[float, Var("mrad", "table, counted backwards")]
def forwards(x, u, p):
    return derivative(x, ball_screw.Input(0.0, 0.0, -1e-3 * u.pull), p)
def output(x, u, p):
    return Output(-1000.0 * x.x_2)
model = Continuous("Theirs", forwards, output, State(), Input(), Parameters())
'''
MAP = """x_2 = { name = "angle", gain = -1 }
d_2 = { name = "pull", gain = -1 }
"""


def test_a_swapped_fmu_gives_the_same_figures_through_its_map(
    feeddrive, drive, tmp_path
):
    (tmp_path / "theirs.py").write_text(THEIRS)
    (tmp_path / "map.toml").write_text(MAP)
    build(str(tmp_path / "theirs.py"), folder=tmp_path)
    inline = MAP.strip().replace("\n", ", ")
    peaks = []
    for given in ((), ("map.toml",), (inline,)):
        swap = ("--swap", "plant=Theirs.fmu", "--map", *given) if given else ()
        result = feeddrive("run", drive, "--json", *swap)
        assert result.exit_code == 0, result.output
        peaks.append(json.loads(result.stdout)["metrics"]["x.peak"]["value"])
    assert peaks[0] > 0
    assert peaks[1:] == [pytest.approx(peaks[0], rel=1e-12)] * 2


def test_schedule_lists_steps_and_ages(feeddrive, drive):
    result = feeddrive("schedule", drive, "--set", "source.latency=2")
    assert result.exit_code == 0, result.output
    assert "plant.d_2" in result.stdout
    assert "100 us" in result.stdout
    plan = json.loads(feeddrive("schedule", drive, "--json").stdout)
    assert plan["stop"] == "1/100"
    steps = {turn["component"]: turn["steps"] for turn in plan["turns"]}
    assert steps["source"] == 201


def test_models_lists_every_module_with_a_description(feeddrive):
    listed = json.loads(feeddrive("models", "--json").stdout)["models"]
    modules = {m["module"]: m for m in listed}
    assert modules["plants.ball_screw.two_mass"]["kind"] == "continuous"
    assert modules["controllers.ball_screw.mc_ppc"]["period"] == "1/20000"
    assert all(m["description"] for m in listed)
    assert "plants.ball_screw.two_mass" in feeddrive("models").stdout


def test_info_shows_variables_with_units(feeddrive):
    result = feeddrive("info", "plants.ball_screw.two_mass")
    assert result.exit_code == 0, result.output
    assert "V.s2/rad" in result.stdout


def test_check_counts_in_words_and_cites_the_version_of_the_fmu(feeddrive):
    refused(
        feeddrive("check", "plants.disturbances.rope_snap", "--only", "99"), "1 to "
    )
    result = feeddrive(
        "check", "plants.disturbances.rope_snap", "--only", "10", "--json"
    )
    (item,) = json.loads(result.stdout)["items"]
    assert "FMI 2.0.5" in item["clause"]
    assert "FMI 3" not in item["clause"]


def test_scenarios_lists_what_run_takes(feeddrive):
    listed = json.loads(feeddrive("scenarios", "gantry", "--json").stdout)["scenarios"]
    titles = {one["name"]: one["title"] for one in listed}
    assert titles["gantry/circle_200"] == "Circle of 200 mm at 200 mm/s"
    assert "gantry/_contour" not in titles
    assert TRACK in feeddrive("scenarios").stdout
    refused(feeddrive("scenarios", "gantri"), "'gantry'")


def test_the_module_runs_as_the_command_and_imports_nothing_heavy():
    heavy = ("numpy", "casadi", "plotly", "pyarrow", "pydantic", "rich.table")
    code = (
        "import sys; sys.argv = ['feeddrive', '--help']\n"
        "import atexit; atexit.register(lambda: print([m for m in "
        f"{heavy!r} if m in sys.modules], file=sys.stderr))\n"
        "import runpy; runpy.run_module('orchestrator', run_name='__main__')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "reproduce" in done.stdout
    loaded = done.stderr.strip().splitlines()[-1]
    assert loaded in ("[]", "['rich.table']")


def test_version_help_and_completion_answer(feeddrive):
    assert re.fullmatch(r"feeddrive \d+\.\d+\.\d+\n", feeddrive("--version").stdout)
    for verb in ((), ("run",), ("runs",)):
        assert "Usage" in feeddrive(*verb, "-h").stdout
    done = subprocess.run(
        [sys.executable, "-m", "orchestrator"],
        env={
            **os.environ,
            "_FEEDDRIVE_COMPLETE": "complete_bash",
            "COMP_WORDS": "feeddrive run ball_screw_pole_placement/mc_ppc_track_1",
            "COMP_CWORD": "2",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert "ball_screw_pole_placement/mc_ppc_track_1000" in done.stdout.split()
