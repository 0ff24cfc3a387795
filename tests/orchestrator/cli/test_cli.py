"""The command: what it prints, where, and how it refuses."""

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from unittest.mock import Mock

import pytest
from typer.testing import CliRunner

from fmus.build import build
from orchestrator.cli import app

TRACK = "ball_screw_pole_placement/mc_ppc_track_500"
DRIVE = """
stop = "0.01"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/20000"
[components.source]
fmu = "plants.disturbances.rope_snap"
step = "1/20000"
[connections]
"plant.d_2" = "source.d_2"
[record]
"plant.x_2" = true
[metrics]
x = { kind = "peak", of = "plant.x_2", unit = "deg" }
"""


@pytest.fixture
def feeddrive(tmp_path, monkeypatch):
    """Run the command in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    return lambda *arguments: CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    file = tmp_path / "drive.toml"
    file.write_text(DRIVE)
    return file


def refused(result, *parts, code=2):
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output
    assert result.exception is None or isinstance(result.exception, SystemExit)
    *_, message = result.stderr.strip().partition("error: ")  # logs may precede it
    message = message or result.stderr
    assert "\n\n" not in message
    for part in parts:
        assert str(part) in message


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


def test_build_writes_fmus_and_says_their_size(feeddrive, tmp_path):
    arguments = (
        "build",
        "plants.disturbances.rope_snap",
        "-o",
        "out",
        "--period",
        "10 kHz",
    )
    (built,) = json.loads(feeddrive(*arguments, "--json").stdout)["fmus"]
    assert Path(built["file"]).stat().st_size == built["bytes"]
    info = json.loads(feeddrive("info", built["file"], "--json").stdout)
    assert info["period"] == "1/10000"
    assert {v["name"] for v in info["variables"]} >= {"d_2", "T_s"}
    assert "KiB" in feeddrive(*arguments).stdout


def test_info_shows_variables_with_units(feeddrive):
    result = feeddrive("info", "plants.ball_screw.two_mass")
    assert result.exit_code == 0, result.output
    assert "V.s2/rad" in result.stdout


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("step =", "stp =", ("components.plant", "'step'")),
        ("stop =", "stop = [", ("TOML",)),
        (
            "plants.ball_screw.two_mass",
            "plants.bal_screw",
            ("components.plant", "bal_screw"),
        ),
        ('"plant.d_2" =', '"plant.d_7" =', ("connections", "'d_2'")),
        ('"source.d_2"', '"source.d_7"', ("connections", "'d_2'")),
        ('"plant.d_2" = "source.d_2"', '"plant.u" = "plant.x_1"', ("rad", "V")),
        ('unit = "deg"', 'unit = "V"', ("metrics.x",)),
        ('unit = "deg"', 'unit = "furlongs per"', ("metrics.x", "furlongs")),
        ("plants.ball_screw.two_mass", "missing.fmu", ("missing.fmu",)),
    ],
)
def test_a_wrong_scenario_ends_in_one_paragraph(feeddrive, drive, old, new, parts):
    drive.write_text(DRIVE.replace(old, new, 1))
    refused(feeddrive("run", drive), drive, *parts)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("run", "ball_screw_pole_placement/mc_ppc_trk_500"), ("mc_ppc_track_500",)),
        (("run", "ball_screw/x"), ("ball_screw_pole_placement",)),
        (("run", "missing.toml"), ("missing.toml",)),
        (("run", "gantry"), ("gantry is a study", "feeddrive scenarios gantry")),
        (("run", "drve.tml"), ("drve.tml: no such scenario file", "drive.toml")),
        (("run", TRACK, "--set", "plant.m_2=true"), ("plant.m_2", "no switch")),
        (("run", TRACK, "--set", "plant.m_2=nan"), ("plant.m_2", "finite")),
        (("run", TRACK, "--set", "plant.m_22=1"), ("plant", "'m_2'")),
        (("run", TRACK, "--set", "plnt.m_2=1"), ("'plant'",)),
        (("run", TRACK, "--swap", "plant"), ("component=their.fmu",)),
        (("run", TRACK, "--swap", "plant=their.fmu"), ("no such file",)),
        (("run", TRACK, "--map", "u = 1"), ("more maps",)),
        (("build",), ("--all",)),
        (("build", "plants.nothing"), ("plants.nothing",)),
        (("build", "nope.py"), ("nope.py: no such file",)),
        (("build", "plants.disturbances.rope_snap", "--period", "0"), ("--period",)),
        (
            ("build", "plants.ball_screw.two_mass", "--period", "1/1000"),
            ("ball_screw",),
        ),
        (("build", "plants.disturbances.rope_snap", "--kind", "wasm"), ("wasm",)),
        (("build", "plants.disturbances.rope_snap", "--platform", "amiga"), ("amiga",)),
        (("info", "missing.fmu"), ("missing.fmu",)),
        (("reproduce", "ball_screw"), ("ball_screw_pole_placement",)),
        (("run",), ("SCENARIO",)),
    ],
)
def test_wrong_usage_ends_in_one_paragraph(feeddrive, drive, arguments, parts):
    refused(feeddrive(*arguments), *parts)


def test_a_feed_through_loop_is_refused_with_its_remedy(feeddrive, tmp_path):
    file = tmp_path / "loop.toml"
    components = "".join(
        f'[components.{name}]\nfmu = "controllers.ball_screw.filter_pack"\n'
        'step = "1/20000"\n'
        for name in ("a", "b")
    )
    file.write_text(
        f'stop = 1\n{components}[connections]\n"a.v" = "b.u"\n"b.v" = "a.u"\n'
        '[record]\n"a.u" = true\n'
    )
    refused(feeddrive("run", file), file, "latency = 1")


def test_damaged_and_unsafe_archives_are_refused(feeddrive, drive, tmp_path):
    fmu = build("plants.ball_screw.two_mass")
    foreign = tmp_path / "foreign.fmu"
    drive.write_text(DRIVE.replace("plants.ball_screw.two_mass", foreign.name))
    foreign.write_bytes(fmu.read_bytes()[:5000])
    refused(feeddrive("run", drive), foreign)
    with zipfile.ZipFile(fmu) as whole, zipfile.ZipFile(foreign, "w") as bare:
        for name in whole.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, whole.read(name))
    refused(feeddrive("run", drive), foreign)
    with zipfile.ZipFile(foreign, "a") as unsafe:
        unsafe.writestr("../../outside.txt", "")
    refused(feeddrive("run", drive), foreign, "outside.txt")


def test_a_stop_a_fixed_step_fmu_cannot_meet_names_the_nearest(
    feeddrive, drive, tmp_path
):
    fixed = tmp_path / "fixed.fmu"
    variable = b'canHandleVariableCommunicationStepSize="true"'
    fixed_step = variable.replace(b"true", b"false")
    with (
        zipfile.ZipFile(build("plants.ball_screw.two_mass")) as whole,
        zipfile.ZipFile(fixed, "w") as changed,
    ):
        for name in whole.namelist():
            content = whole.read(name).replace(variable, fixed_step)
            changed.writestr(name, content)
    drive.write_text(DRIVE.replace("plants.ball_screw.two_mass", fixed.name))
    refused(feeddrive("run", drive, "--set", "stop=0.01001"), "1/100", "201/20000")


def test_a_failed_run_ends_with_code_1_and_leaves_its_rows(feeddrive, drive):
    diverging = ("--set", "plant.m_12=1e-3", "--set", "stop=20")
    result = feeddrive("run", drive, *diverging, "-o", "out", "--json")
    refused(result, "plant", code=1)
    assert json.loads(result.stdout)["result"] == "out"
    assert list(Path("out/result").glob("*.arrows"))


def test_an_interrupted_run_ends_with_130(feeddrive, drive, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("orchestrator.master.simulate.simulate", interrupted)
    refused(feeddrive("run", drive), "interrupted", code=130)


def test_an_interrupted_run_says_where_its_rows_are_if_it_has_any(
    feeddrive, drive, monkeypatch
):
    from orchestrator.master.simulate import simulate

    def interrupted(*arguments, **options):
        simulate(*arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr("orchestrator.master.simulate.simulate", interrupted)
    refused(feeddrive("run", drive, "-o", "out"), "t = 0.01 s", "out/result", code=130)
    monkeypatch.setattr(
        "orchestrator.scenario.compose.compose", Mock(side_effect=KeyboardInterrupt)
    )
    result = feeddrive("run", drive, "-o", "out")
    refused(result, "interrupted", code=130)
    assert "rows" not in result.stderr


def test_with_json_an_error_is_json_on_stdout_too(feeddrive):
    result = feeddrive("run", "nowhere.toml", "--json")
    refused(result, "nowhere.toml: no such scenario file")
    assert "no such scenario file" in json.loads(result.stdout)["error"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_full_disk_behind_stdout_is_called_standard_output(more):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "orchestrator", "scenarios", *more],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 1
    assert done.stderr.startswith("error: standard output: ")
    assert len(done.stderr.splitlines()) == 1


OF_FMI_1 = '<fmiModelDescription fmiVersion="1.0" modelIdentifier="a" guid="1"/>'


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "an empty file"),
        (b"\x7fELF\x02\x01", "a program"),
        (b"hello\nworld", "a text that begins with 'hello'"),
        (b"\x00\x01\x02\x03\x04", "bytes 00 01 02 03"),
        ({"a.txt": "x"}, "zip archive without modelDescription.xml; it holds a.txt"),
        ({"modelDescription.xml": OF_FMI_1}, "is FMI 1.0, which is not supported"),
    ],
)
def test_a_file_that_is_no_fmu_is_called_what_it_is(feeddrive, content, said):
    file = Path("their.fmu")
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        with zipfile.ZipFile(file, "w") as archive:
            for name, text in content.items():
                archive.writestr(name, text)
    result = feeddrive("check", file)
    refused(result, file, said)
    assert result.stdout == ""
    refused(feeddrive("info", file), file)


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


def test_a_fault_of_ours_is_one_paragraph_too(feeddrive, drive, monkeypatch):
    def faulty(*_, **__):
        raise TypeError("an integer is required")

    monkeypatch.setattr("orchestrator.master.simulate.simulate", faulty)
    result = feeddrive("run", drive)
    refused(result, "fault in feeddrive", "an integer", "FEEDDRIVE_TRACEBACK", code=1)


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
