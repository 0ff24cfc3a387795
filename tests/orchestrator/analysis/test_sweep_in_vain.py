"""What a sweep does not pretend: that something was varied, or was expected."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.analysis.breaks import until_breaks
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.tolerances import tolerances_of
from orchestrator.analysis.variations import Axis, parse_axis
from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "does_it_hold"
DRIVE = EXAMPLE / "drive.toml"
SHORT = ["stop=0.05"]
HELD = """
base = "ball_screw_pole_placement/mc_ppc_track_500"
[expect]
"tracking.peak" = { below = 4, unit = "um" }
"""


def test_a_sweep_that_expects_nothing_has_no_yield(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All members met what nobody had asked for: 100 %."""
    monkeypatch.chdir(tmp_path)
    published = "ball_screw_pole_placement/mc_ppc_track_500"
    given = [published, "--vary", "plant.m_2=4e-4", "--set", "stop=0.05"]
    done = CliRunner().invoke(app, ["sweep", *given])
    assert "no yield without [expect]" in done.stdout
    assert "yield 100" not in done.stdout


def test_what_a_connection_drives_is_not_varied_in_vain() -> None:
    with pytest.raises(ScenarioError, match=r"--vary plant\.u: controller\.u drives"):
        sweep(DRIVE, [Axis("plant.u", ("0", "5"))], sets=SHORT)
    with pytest.raises(ScenarioError, match=r"--until-breaks controller\.y_1: "):
        until_breaks(DRIVE, "controller.y_1", ["controller.y_1=1"])
    open_loop = [*SHORT, "connections.plant.u=false"]
    low, high = sweep(DRIVE, [Axis("plant.u", (0.0, 5.0))], sets=open_loop).rows
    assert low["tracking.peak"] != high["tracking.peak"]


def test_a_percentage_of_zero_is_refused_not_varied_by_nothing(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="of which every percentage is 0"):
        parse_axis("a.b=+-20%:3", lambda _: 0.0)
    file = tmp_path / "held.toml"
    file.write_text(HELD + '[tolerances]\n"plant.b_2" = "+-20 %"\n')
    with pytest.raises(ScenarioError, match=r"b_2 is 0, of which every percentage"):
        tolerances_of(compose(load_scenario(file), run_earlier))
