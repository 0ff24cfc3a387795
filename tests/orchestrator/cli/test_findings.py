"""A run that goes badly is told in figures: what it lacks, and why."""

import json
import shutil
from pathlib import Path

import pytest
from click.testing import Result
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.supplied import PROJECT as EXAMPLE


@pytest.fixture
def drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The own drive of the docs, in the current folder."""
    for part in ("models", "tests"):
        shutil.copytree(EXAMPLE / part, tmp_path / part)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path / "tests" / "speed_step.toml"


def feeddrive(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_a_drive_that_does_not_settle_keeps_its_figures_and_report(drive: Path) -> None:
    result = feeddrive("run", drive, "--set", "controller.K_p=0.02", "-o", "out")
    assert result.exit_code == 1
    assert "not settled: the error is -198.446 rad/s at 0.1 s" in result.stdout
    assert "207.351" in result.stdout
    assert "speed.settling: not settled" in result.stderr
    assert "speed.overshoot" not in result.stderr  # a changed scenario may differ
    found = json.loads(Path("out/metrics.json").read_text())["metrics"]
    assert found["speed.settling"]["value"] is None
    assert found["speed.settling"]["why"].startswith("not settled: the error")
    assert found["speed.overshoot"]["value"] == pytest.approx(207.351, abs=1e-3)
    assert "not settled: the error" in Path("out/report.html").read_text()


def test_a_swap_that_does_not_settle_stands_beside_the_original(drive: Path) -> None:
    text = Path("models/speed_pi.py").read_text()
    assert "= 1.5" in text
    Path("models/their_pi.py").write_text(text.replace("= 1.5", "= 0.02"))
    swap = ("--swap", "controller=models/their_pi.py", "-o", "out")
    result = feeddrive("run", drive, *swap)
    assert result.exit_code == 1
    assert "Original against swapped" in result.stdout
    assert "swapped: speed.settling: not settled" in result.stdout
    assert "original: speed.settling" not in result.stdout
    printed = json.loads(feeddrive("run", drive, *swap, "--overwrite", "--json").stdout)
    assert json.loads(Path("out/metrics.json").read_text()) == printed
    assert printed["metrics"]["speed.settling"]["value"] is None
    assert printed["original"]["speed.settling"]["value"] > 0


def test_a_wrong_signal_of_a_metric_is_refused_before_the_run(drive: Path) -> None:
    drive.write_text(drive.read_text().replace('of = "motor.omega"', 'of = "motor.w"'))
    result = feeddrive("run", drive, "-o", "out")
    assert result.exit_code == 2
    assert "motor.w" in result.stderr
    assert not Path("out").exists()


def test_a_wrong_sign_is_named_in_one_line_without_warnings(drive: Path) -> None:
    Path("models/their_pi.py").write_text(
        Path("models/speed_pi.py").read_text().replace("= 1.5", "= -50.0")
    )
    swap = ("--swap", "controller=models/their_pi.py", "-o", "out")
    result = feeddrive("run", drive, *swap)
    assert result.exit_code == 1
    named = "diverged: motor.omega passes 1e+08 rad/s at t = 0.003 s"
    assert named in result.stderr.splitlines()
    assert "> 1e+06 %" in result.stdout
    assert max(map(len, result.stdout.splitlines())) <= 200
    assert "Warning" not in result.output
    assert "diverged: motor.omega" in Path("out/report.html").read_text()
    assert "diverged: " in json.loads(Path("out/metrics.json").read_text())["diverged"]


def test_a_run_that_overflows_says_that_it_diverged(drive: Path) -> None:
    result = feeddrive("run", drive, "--set", "controller.K_p=-500", "-o", "out")
    assert result.exit_code == 1
    assert "diverged: motor.omega passes 1e+08 rad/s" in result.stderr
