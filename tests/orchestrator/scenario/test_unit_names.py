"""Unit names of a scenario mean what the FMU at hand defines them to be."""

import json
import zipfile
from pathlib import Path

import pytest

from orchestrator import load_scenario, run
from orchestrator.errors import ScenarioError
from orchestrator.supplied import build_supplied

PER_MINUTE = 0.10471975511965978  # rad/s, whatever the name looks like
SPEED = '<Unit name="mm/s"><BaseUnit m="1" s="-1" factor="0.001"/></Unit>'
TURNS = f'<Unit name="1/min"><BaseUnit rad="1" s="-1" factor="{PER_MINUTE}"/></Unit>'
SCENARIO = """\
stop = "0.01"
[components.drive]
fmu = "ball_screw.fmu"
step = "1/20000"
parameters = { lead = "25 mm/rev", inertia_table = "0.4 mVs2/rad" }
start = { motor_voltage = "-5000 mV", ambient = "300 K" }
[record]
"drive.table_speed" = true
"drive.ambient" = true
[metrics]
own = { kind = "max", of = "drive.table_speed" }
si = { kind = "max", of = "drive.table_speed", unit = "rad/s" }
named = { kind = "max", of = "drive.table_speed", unit = "1/min" }
per = { kind = "max", of = "drive.table_speed", per = "2 1/min" }
made = { kind = "max", of = "drive.table_speed", scale = "drive.lead", unit = "mm/s" }
hall = { kind = "mean", of = "drive.ambient", unit = "degF" }
span = { kind = "span", of = "drive.ambient", unit = "degC" }
[expect]
"own.max" = { above = 0, below = 1e4, unit = "deg/s" }
"span.span" = { near = 0, within = 1e-9, unit = "K" }
"""


def described(fmu: Path, file: Path, *changes: tuple[str, str]) -> None:
    """Write an FMU again with another text in its model description."""
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    text = content["modelDescription.xml"].decode()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    content["modelDescription.xml"] = text.encode()
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scenario with the supplied drive, whose speeds are in turns per minute."""
    built = build_supplied("supplied.ball_screw", tmp_path / "as it is")
    changes = (SPEED, TURNS), ('unit="mm/s"', 'unit="1/min"')
    described(built, tmp_path / "ball_screw.fmu", *changes)
    (tmp_path / "s.toml").write_text(SCENARIO)
    return tmp_path


def test_metrics_factors_and_expectations_agree(folder: Path):
    done = run(load_scenario(folder / "s.toml"), folder / "run", report=False)
    assert done.warnings == ()
    figures = {name.partition(".")[0]: figure for name, figure in done.metrics.items()}
    speed = float(done["drive.table_speed"].values.max())
    assert (figures["own"].value, figures["own"].unit) == (speed, "1/min")
    assert figures["si"].value == pytest.approx(speed * PER_MINUTE, rel=1e-15)
    assert (figures["named"].value, figures["per"].value) == (speed, speed / 2)
    of_travel = speed * PER_MINUTE * 25 / (2 * 3.141592653589793)
    assert figures["made"].value == pytest.approx(of_travel)
    assert figures["hall"].value == pytest.approx(80.33)
    assert all(check.met for check in done.checks)
    again = run(load_scenario(folder / "run/scenario.lock.toml"), folder / "again")
    assert {n: f.value for n, f in again.metrics.items()} == {
        n: f.value for n, f in done.metrics.items()
    }


@pytest.mark.parametrize(
    ("removed", "by", "said"),
    [
        (TURNS, "", "names the unit 1/min without defining it"),
        (TURNS, TURNS.replace('rad="1" ', ""), None),
        ('unit="1/min"', 'unit="bits"', None),
    ],
)
def test_what_is_a_guess_is_told_in_json_and_report_or_refused(
    folder: Path, removed: str, by: str, said: str | None
):
    fmu = folder / "ball_screw.fmu"
    described(fmu, fmu, (removed, by))
    text = SCENARIO.replace('made = { kind = "max"', 'made = { kind = "min"')
    kept = [line for line in text.splitlines() if not line.startswith(("made", "per"))]
    if said:  # by its name it is turns per second: of no angle
        kept = [line.replace("rad/s", "1/s").replace("deg/s", "1/s") for line in kept]
    (folder / "s.toml").write_text("\n".join(kept))
    scenario = load_scenario(folder / "s.toml")
    if said is None:
        with pytest.raises(ScenarioError, match=r"metrics\.si: .* cannot become rad/s"):
            run(scenario, folder / "run")
        return
    done = run(scenario, folder / "run")
    assert any(said in warning for warning in done.warnings)
    told = json.loads((folder / "run/metrics.json").read_text())
    assert any(said in warning for warning in told["warnings"])
    assert said in (folder / "run/report.html").read_text()
