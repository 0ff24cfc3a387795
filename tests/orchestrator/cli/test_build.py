"""The verb ``build``: what it writes, and what of."""

import json
from pathlib import Path

import fmpy
from command import refused


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


def test_build_makes_the_fmu_of_a_file_of_signals(feeddrive, tmp_path):
    """Its values between the rows, its period and its unit, in plain FMPy."""
    (tmp_path / "force.csv").write_text("t [s],F [N]\n0,0\n0.001,4\n0.002,2\n")
    linear = ("--interpolation", "linear", "--period", "1/4000")
    found = {}
    for name, options in (("hold", ()), ("linear", linear)):
        arguments = ("build", "force.csv", "-o", name, *options, "--json")
        (built,) = json.loads(feeddrive(*arguments).stdout)["fmus"]
        fmu = built["file"]
        info = json.loads(feeddrive("info", fmu, "--json").stdout)
        units = {v["name"]: v["unit"] for v in info["variables"]}
        assert units["F"] == "N"
        rows = fmpy.simulate_fmu(fmu, stop_time=0.002, output_interval=0.00025)
        found[name] = info["period"], [float(v) for v in rows["F"]]
    assert found == {  # what a tick gives is read after the step that begins with it
        "hold": ("1/1000", [0.0] * 5 + [4.0] * 4),
        "linear": ("1/4000", [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 3.5, 3.0, 2.5]),
    }


def test_build_says_what_rows_between_signals_may_be(feeddrive, tmp_path):
    (tmp_path / "force.csv").write_text("F [N]\n0\n1\n")
    wrong = feeddrive("build", "force.csv", "--interpolation", "cubic")
    refused(wrong, "--interpolation cubic: choose hold or linear")
    refused(feeddrive("build", "force.csv"), "rate")
    refused(feeddrive("build", "force.csv", "--rate", "often"), "--rate")
