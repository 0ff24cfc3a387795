"""A supplier's drive behind a socket follows as the loop in SI units does."""

import json
from pathlib import Path

import numpy as np
import pytest
from foreign_drive import drive
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.scenario.override import parse_swaps
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

MODEL = Path(__file__).parent / "models" / "servo.py"
INCREMENT = 2 * np.pi / 2**20  # rad
SCENARIO = f"""
stop = "0.1"
[components.tone]
fmu = "controllers.references.sine"
step = "1 kHz"
parameters = {{ amplitude = 0.01, frequency_hz = 20, t_0 = 0.01 }}
map = {{ x_r = {{ name = "x_r", gain = 100, unit = "rad" }} }}
[components.drive]
fmu = "{MODEL}"
step = "1 kHz"
[connections]
"drive.wanted" = "tone.x_r"
[record]
"drive.angle" = true
"""
LINES = """
wanted = "x_r"
angle = "x"
status_word = "6041h"
"""
NEAR_THE_END = 2**31 - 20_000  # increments before the position runs over


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drive")
    (folder / "servo.toml").write_text(SCENARIO)
    (folder / "lines.toml").write_text(LINES)
    return folder


@pytest.fixture(scope="module")
def servo(place: Path) -> np.ndarray:
    done = run(place / "servo.toml", place / "si", report=False)
    return done["drive.angle"].values


def behind(
    place: Path, folder: Path, mode: int, socket: str, lines: str, *sets: str
) -> np.ndarray:
    swaps = parse_swaps([f"drive={drive(mode, place)}"], [lines], [socket])
    loaded = load_scenario(place / "servo.toml", sets, swaps)
    return run(loaded, folder / "run", report=False)["drive.angle"].values


def test_a_drive_in_increments_follows_to_its_quantisation(
    place: Path, tmp_path: Path, servo: np.ndarray
) -> None:
    assert np.abs(servo).max() > 0.3
    found = behind(place, tmp_path, 402, "csp", str(place / "lines.toml"))
    assert 0 < np.abs(found - servo).max() < 1.5 * INCREMENT


def test_a_position_that_runs_over_is_followed_on(
    place: Path, tmp_path: Path, servo: np.ndarray
) -> None:
    """The drive stands before the end of its 32 bits and passes it to and fro."""
    home = NEAR_THE_END * INCREMENT
    lines = f"""
wanted = {{ name = "x_r", offset = {home!r}, gain = 1 }}
angle = {{ name = "x", offset = {-home!r}, gain = 1 }}
status_word = "6041h"
"""
    found = behind(
        place, tmp_path, 402, "csp", lines, f"drive_fmu.stands_at={NEAR_THE_END}"
    )
    assert np.abs(found - servo).max() < 1.5 * INCREMENT


def test_telegram_105_closes_the_loop_in_the_drive(
    place: Path, tmp_path: Path, servo: np.ndarray
) -> None:
    lines = '\nwanted = "x_r"\nangle = "x"\n'
    found = behind(place, tmp_path, 105, "telegram_105", lines)
    assert 0 < np.abs(found - servo).max() < 1.5 * INCREMENT


def test_the_other_side_is_a_sign_of_the_adapter(
    place: Path, tmp_path: Path, servo: np.ndarray
) -> None:
    """With the side turned round both ways nothing is seen from ours."""
    lines = str(place / "lines.toml")
    found = behind(place, tmp_path, 402, "csp", lines, "drive.side=-1")
    assert np.abs(found - servo).max() < 1.5 * INCREMENT


def test_what_a_socket_lacks_is_named(place: Path) -> None:
    swaps = [f"drive={drive(402, place)}"]
    with pytest.raises(ScenarioError, match="did you mean"):
        parse_swaps(swaps, [], ["cps"])
    with pytest.raises(ScenarioError, match=r"called target_velocity.*Inputs are Con"):
        parse_swaps(swaps, [], ["csv"])
    with pytest.raises(ScenarioError, match="no such output"):
        parse_swaps(swaps, ['status_word = "6042h"'], ["csp"])
    with pytest.raises(ScenarioError, match="more sockets than swaps"):
        parse_swaps([], [], ["csp"])


def test_the_command_line_plugs_a_drive_in_beside_the_original(
    place: Path, tmp_path: Path
) -> None:
    asked = ["run", str(place / "servo.toml"), "-o", str(tmp_path / "run"), "--json"]
    asked += ["--swap", f"drive={drive(402, place)}", "--socket", "csp"]
    done = CliRunner().invoke(app, [*asked, "--map", str(place / "lines.toml")])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["metrics"] == {}
