"""Where names differ a map is proposed, nothing is applied, and A stands by B."""

import json
import tomllib
from pathlib import Path

import pytest
from systems import MODELS
from typer.testing import CliRunner

from fmus.build import build
from orchestrator.cli import app
from orchestrator.fmu.description import read_fmu
from orchestrator.scenario.propose import missing_names, propose, to_toml

SCENARIO = "ball_screw_pole_placement/mc_ppc_track_500"
PER_MM = 2 * 3.141592653589793 / 20
RIGHT = {"u": "motor_voltage", "d_2": "table_force", "x_1": "screw", "x_2": "table"}


@pytest.fixture
def supplied() -> Path:
    return build(str(MODELS / "disguised.py"))


def test_the_proposal_pairs_what_belongs_together(supplied: Path) -> None:
    ours, theirs = read_fmu(build("plants.ball_screw.two_mass")), read_fmu(supplied)
    found = propose(list(RIGHT), ours, theirs)
    assert {p.ours.name: p.theirs and p.theirs.name for p in found} == RIGHT


def test_the_proposal_is_a_map_with_its_doubts(supplied: Path) -> None:
    ours, theirs = read_fmu(build("plants.ball_screw.two_mass")), read_fmu(supplied)
    text = to_toml(propose(["u", "x_1"], ours, theirs))
    assert tomllib.loads(text) == {
        "u": "motor_voltage",
        "x_1": {"name": "screw", "gain": 1.0, "unit": "rad"},
    }
    assert "CHECK: set the gain from mm to rad and the sign" in text


def test_equal_units_and_descriptions_leave_no_doubt() -> None:
    ours = read_fmu(build("plants.gantry.x_axis"))
    found = propose(["u", "d", "x", "v"], ours, ours)
    assert all(p.theirs == p.ours and not p.doubts for p in found)


def test_what_nothing_fits_is_said() -> None:
    ours = read_fmu(build("plants.gantry.x_axis"))
    theirs = read_fmu(build("controllers.references.sine"))
    (found,) = propose(["u"], ours, theirs)
    assert found.theirs is None
    assert found.to_toml() == "# u: nothing fits (u [V] control signal)"


def test_records_and_arrays_are_no_missing_names() -> None:
    fmu = read_fmu(build("controllers.ball_screw.mc_ppc"))
    parts = [name.partition(".")[0] for name in fmu.variables]
    assert missing_names(parts, fmu) == []
    assert missing_names(["nothing"], fmu) == ["nothing"]


def test_a_swap_without_a_map_proposes_and_does_nothing(
    supplied: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    result = CliRunner().invoke(
        app, ["run", SCENARIO, "--swap", f"plant={supplied}", "-o", str(folder)]
    )
    assert result.exit_code == 2
    assert "was not applied" in result.output
    assert 'u = { name = "motor_voltage", gain = -1 }' in result.output
    assert "measured: mm for rad by u -3.1831" in result.output
    assert not folder.exists()


def test_original_and_swapped_are_printed_and_drawn_together(
    supplied: Path, tmp_path: Path
) -> None:
    table = tmp_path / "map.toml"
    table.write_text(
        'u = { name = "motor_voltage", gain = -1 }\n'
        f'x_1 = {{ name = "screw", gain = {PER_MM!r}, unit = "rad" }}\n'
        f'x_2 = {{ name = "table", gain = {PER_MM!r}, unit = "rad" }}\n'
    )
    arguments = ["run", SCENARIO, "--swap", f"plant={supplied}", "--map", str(table)]
    folder = tmp_path / "run"
    result = CliRunner().invoke(app, [*arguments, "-o", str(folder)])
    assert result.exit_code == 0, result.output
    assert "Original against swapped" in result.output
    page = (folder / "report.html").read_text()
    assert "original: plant.x_2" in page
    assert "swapped: plant.x_2" in page
    assert f"plant = {supplied.name}</h1>" in page
    again = str(tmp_path / "again")
    result = CliRunner().invoke(app, [*arguments, "-o", again, "--json"])
    told = json.loads(result.stdout)
    assert told["original"].keys() == told["metrics"].keys()


def test_what_is_set_on_the_swapped_component_is_not_set_on_the_original(
    tmp_path: Path,
) -> None:
    swap = ("--swap", "plant=plants.ball_screw.drive", "--json")
    own = ("--set", "plant.current_loop.on=true")  # the original has no such part
    result = CliRunner().invoke(
        app, ["run", SCENARIO, *swap, *own, "-o", str(tmp_path / "run")]
    )
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["original"]["u.peak"] != told["metrics"]["u.peak"]


def test_a_map_out_lists_what_equal_names_hide(tmp_path: Path) -> None:
    """Same names, but the motor reversed: nothing is missing, and the pulse tells."""
    model = (MODELS / "disguised.py").read_text()
    for theirs, ours in (("motor_voltage", "u"), ("table_force", "d_2")):
        model = model.replace(theirs, ours)
    same = tmp_path / "same.py"
    model = model.replace("screw: Ann", "x_1: Ann").replace("table: Ann", "x_2: Ann")
    same.write_text(model.replace("PER_RAD * x", "x").replace('Var("mm"', 'Var("rad"'))
    file = tmp_path / "map.toml"
    arguments = ["run", SCENARIO, "--swap", f"plant={same}", "--map-out", str(file)]
    result = CliRunner().invoke(app, [*arguments, "--trust"])
    assert result.exit_code == 0, result.output
    assert tomllib.loads(file.read_text())["u"] == {"name": "u", "gain": -1}
    assert "x_1" not in tomllib.loads(file.read_text())
    again = CliRunner().invoke(app, arguments)
    assert again.exit_code == 2
    assert "there is such a file" in again.output
    assert not (tmp_path / "runs").exists()
