"""What is refused or fails: one paragraph, an exit code, never a traceback."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path
from unittest.mock import Mock

import pytest
from command import DRIVE, TRACK, refused

from fmus.build import build


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


def test_a_fault_of_ours_is_one_paragraph_too(feeddrive, drive, monkeypatch):
    def faulty(*_, **__):
        raise TypeError("an integer is required")

    monkeypatch.setattr("orchestrator.master.simulate.simulate", faulty)
    result = feeddrive("run", drive)
    refused(result, "fault in feeddrive", "an integer", "FEEDDRIVE_TRACEBACK", code=1)
