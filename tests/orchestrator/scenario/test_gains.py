"""Gains made of parameters, with units; whole numbers rounded into their range."""

from fractions import Fraction
from math import floor
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from stub import Stub, library, stub

from orchestrator.errors import FeedDriveError
from orchestrator.fmu.whole import Whole
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

SCENARIO = """
stop = "2 ms"
[components.tone]
fmu = "controllers.references.sine"
step = "1 kHz"
[components.drive]
fmu = "drive.fmu"
step = "1 kHz"
parameters = { counts = 4096, lead = 10, rated = 2.5 }
[components.drive.map]
x = { name = "position", gain = "lead / counts", offset = 1.0, unit = "mm" }
torque = { name = "actual", gain = "rated / 1000" }
x_r = { name = "target", gain = "counts / lead", range = "saturate" }
[connections]
"drive.x_r" = "tone.x_r"
[record]
"drive.x" = true
"drive.torque" = true
"drive.counted" = true
"tone.x_r" = true
"""
DRIVE = {
    "target": Stub("input", "Integer"),
    "counts": Stub("parameter", start="4096"),
    "lead": Stub("parameter", unit="mm", start="10"),
    "rated": Stub("parameter", unit="N.m", start="2.5"),
    "position": Stub("output", "Real"),
    "actual": Stub("output", "Real"),
    "counted": Stub("output", "Integer"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("gains")
    stub(library(place), place / "drive.fmu", DRIVE)
    return place


def scenario(folder: Path, text: str = SCENARIO) -> Path:
    file = folder / "drive.toml"
    file.write_text(text)
    return file


def test_gains_are_worked_out_with_their_units(folder: Path) -> None:
    loaded = load_scenario(scenario(folder), ["drive.counts=8192"])
    found = compose(loaded, run_earlier)
    x, torque, x_r = found.system.components["drive"].map.values()
    assert (x.gain, x.offset, x.unit) == (10 / 8192, 1.0, "mm")
    assert (torque.gain, torque.unit) == (0.0025, "N.m")
    assert x_r.gain == 8192 / 10  # per mm; the tone's metres are converted
    assert x_r.unit == "mm"
    assert found.in_gains == {"drive.counts", "drive.lead", "drive.rated"}


def test_what_reaches_an_integer_is_rounded(folder: Path) -> None:
    done = run(scenario(folder), folder / "run", report=False)
    x_r, counts = done["tone.x_r"].values, done["drive.counted"].values
    expected = [floor(409600 * float(x) + 0.5) for x in x_r]
    assert counts.tolist()[1:] == expected[:-1]
    assert expected[1] == 13
    assert float(done["drive.torque"].values[-1]) == 10 * 0.0025


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"rated / 1000"', '"rated / 0"', "0 is zero"),
        ('"rated / 1000"', '"rated ^ 2"', "write numbers, parameters, pi"),
        ('"rated / 1000"', '"rate / 1000"', "has no variable 'rate'"),
        ('gain = "lead / counts"', 'gain = "rated / counts"', "different quantities"),
        (', range = "saturate"', "", 'range = "saturate" or "wrap"'),
        ('"actual", gain', '"actual", range = "wrap", gain', "is for integer inputs"),
        ('name = "actual"', 'name = "lead"', "an expression is for inputs and outputs"),
    ],
)
def test_what_is_no_gain_is_refused(
    folder: Path, old: str, new: str, told: str
) -> None:
    assert old in SCENARIO
    file = scenario(folder, SCENARIO.replace(old, new))
    with pytest.raises(FeedDriveError, match=told):
        run(file, folder / "never", report=False)


@given(
    st.floats(-1e15, 1e15),
    st.sampled_from([(-(2**31), 2**31 - 1), (0, 65535), (-3, 6)]),
)
@example(0.5, (-3, 6))
@example(-0.5, (-3, 6))
@example(6.5, (-3, 6))
@example(2.0**31 - 0.5, (-(2**31), 2**31 - 1))
def test_a_range_is_kept_as_whole_numbers_say(
    value: float, ends: tuple[int, int]
) -> None:
    low, high = ends
    whole = (Fraction(value + 0.5)).__floor__()
    assert Whole("saturate", low, high).of(value) == min(max(whole, low), high)
    span = high - low + 1
    assert Whole("wrap", low, high).of(value) == (whole - low) % span + low
