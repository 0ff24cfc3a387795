"""Scenarios from end to end through real FMUs, short and small."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import orchestrator
from fmus.build import BuildError
from orchestrator.errors import DesignError, FmuError, ScenarioError, WiringError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import (
    STUDIES,
    load_scenario,
    read_scenario,
    scenarios,
)
from orchestrator.session import run, run_earlier

DRIVE = """
title = "Short move"
stop = "0.02"
[rates]
control = "20 kHz"
[components.trajectory]
fmu = "controllers.references.trajectory"
step = "control"
parameters = { stroke = 1e-4, t_0 = 0 }
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "control"
[components.controller]
fmu = "controllers.ball_screw.mc_ppc"
latency = 1
[connections]
"controller.*" = "trajectory.*"
"controller.y_*" = "plant.x_*"
"controller.u_d" = 0.25
"plant.u" = "controller.u"
[design.gains]
call = "controllers.synthesis.ball_screw.pole_placement:design"
arguments = { m_1 = "plant.m_1", m_2 = "plant.m_2", b_1 = "plant.b_1", b_2 = "plant.b_2", k = "plant.k", c = "plant.c" }
sets = "controller"
[record]
"plant.x_*" = true
"trajectory.x_r" = "control"
"controller.u" = "1 kHz"
[metrics]
tracking = { kind = "error", of = "plant.x_2", against = "trajectory.x_r", scale = "plant.r_g", unit = "um" }
u = { kind = "peak", of = "controller.u" }
[expect]
"u.peak" = { above = 0, unit = "mV" }
"""  # noqa: E501 - inline tables of TOML are one line


BARE = '''"""The drive without the parameters that a figure or a design may ask for."""
from typing import NamedTuple
from fmus.model import Continuous
from plants.ball_screw import two_mass as ball_screw
from plants.ball_screw.two_mass import Input, State
class Parameters(NamedTuple):
    """None."""
def derivative(x, u, p):
    return ball_screw.derivative(x, u, ball_screw.Parameters())
def output(x, u, p):
    return ball_screw.output(x, u, ball_screw.Parameters())
model = Continuous("Bare", derivative, output, State(), Input(), Parameters())
'''
CONTINUOUS_STEP = 'step = "control"\n[components.controller]'


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    file = tmp_path / "drive.toml"
    file.write_text(DRIVE)
    return file


def composed(file, *overrides):
    return compose(load_scenario(file, overrides), run_earlier)


def test_a_run_gives_signals_figures_checks_and_a_folder(drive, tmp_path):
    told = []
    done = run(load_scenario(drive), tmp_path / "out", progress=told.append)
    assert len(done["plant.x_2"]) == len(done["trajectory.x_r"]) == 401
    assert len(done["controller.u"]) == 21
    assert done["plant.x_2"].unit == "rad"
    assert done["plant.x_2"].time[-1] == 0.02
    assert told[-1] == Fraction(1, 50)
    error = (
        1e6
        * 0.020
        / (2 * np.pi)
        * np.subtract(done["trajectory.x_r"], done["plant.x_2"])
    )
    assert done.metrics["tracking.peak"].value == pytest.approx(np.max(np.abs(error)))
    assert [check.met for check in done.checks] == [True]
    written = json.loads((tmp_path / "out/metrics.json").read_text())
    assert written == done.summary()
    keys = {"scenario", "stop", "metrics", "diverged", "timing", "result"}
    assert set(written) == keys | {
        *("number", "warnings", "executor", "ended", "undriven", "not_taken_over"),
        *("values", "unlike"),
    }
    assert (written["warnings"], written["executor"]) == ([], "kernel")
    assert written["number"] is None
    assert written["diverged"] is None
    page = (tmp_path / "out/report.html").read_text()
    assert "Short move" in page
    assert "http://" not in page.partition("<body>")[0]


def test_what_is_warned_of_stands_in_json_and_report(drive, tmp_path, caplog):
    scenario = load_scenario(drive, ["controller.latency=500"])
    done = run(scenario, tmp_path / "out")
    said = "nothing that controller computes is published before the run ends"
    assert [said in text for text in done.warnings] == [True]
    assert caplog.text.count(said) == 1
    written = json.loads((tmp_path / "out/metrics.json").read_text())
    assert written["warnings"] == list(done.warnings)
    assert said in (tmp_path / "out/report.html").read_text()


def test_the_lock_file_gives_the_same_run_again(drive, tmp_path):
    scenario = load_scenario(drive, ["plant.m_2=0.4e-3", "controller.K_acc=1e-7"])
    first = run(scenario, tmp_path / "first", report=False)
    lock = tmp_path / "first/scenario.lock.toml"
    again = run(lock, tmp_path / "again", report=False)
    with pytest.raises(ScenarioError, match="another folder"):
        run(lock, tmp_path / "first", report=False)
    for name in first:
        assert np.array_equal(first[name].values, again[name].values)
    assert again.metrics == first.metrics


def test_a_swapped_plant_runs_again_from_its_lock_file(drive, tmp_path):
    (tmp_path / "bare.py").write_text(BARE)
    swap = {"plant": {"fmu": "bare.py"}}
    first = run(load_scenario(drive, (), swap), tmp_path / "first", report=False)
    lock = tmp_path / "first/scenario.lock.toml"
    again = run(lock, tmp_path / "again", report=False)
    assert again.metrics == first.metrics
    usual = run(drive, tmp_path / "usual", report=False)
    assert first.metrics["tracking.peak"] == usual.metrics["tracking.peak"]


def test_a_lock_file_refuses_an_fmu_that_changed(drive, tmp_path):
    run(load_scenario(drive), tmp_path / "out", report=False)
    fmus = tmp_path / "out/fmus"
    (fmus / "plant.fmu").write_bytes((fmus / "controller.fmu").read_bytes())
    with pytest.raises(ScenarioError, match=r"components\.plant: the FMU differs"):
        run(tmp_path / "out/scenario.lock.toml", tmp_path / "again", report=False)


def test_set_changes_one_component_and_not_what_the_design_is_told(drive):
    plain, heavy = composed(drive), composed(drive, "plant.m_2=0.5685e-3")
    gains = [c.system.components["controller"].parameters for c in (plain, heavy)]
    assert gains[0] == gains[1]
    assert heavy.parameter("plant.m_2").value == 0.5685e-3
    assert heavy.designs["gains"].arguments["m_2"] == 0.379e-3


def test_redesigning_changes_the_gains_and_set_wins_over_design(drive):
    override = "design.gains.m_2=0.5685e-3"
    redesigned = composed(drive, override, "controller.K_x1=1")
    gains = redesigned.system.components["controller"].parameters
    assert gains["K_x1"] == 1.0
    assert gains["K_x2"] != composed(drive).parameter("controller.K_x2").value
    assert redesigned.parameter("plant.m_2").value == 0.379e-3


def test_a_sampled_model_is_built_for_its_step(drive):
    slow = composed(drive, "rates.control=10 kHz", "controller.step=1/5000")
    periods = {name: fmu.period for name, fmu in slow.fmus.items()}
    assert periods["trajectory"] == Fraction(1, 10_000)
    assert periods["controller"] == Fraction(1, 5000)
    assert slow.system.components["plant"].period == Fraction(1, 10_000)


def test_stars_are_opened_and_constants_become_start_values(drive):
    system = composed(drive).system
    assert system.connections["controller.s_r"] == "trajectory.s_r"
    assert system.connections["controller.y_2"] == "plant.x_2"
    assert "controller.u_d" not in system.connections
    assert system.components["controller"].start == {"u_d": 0.25}
    assert set(system.record) > {"plant.x_1", "plant.x_2", "plant.x_t"}


@pytest.mark.parametrize(
    ("old", "new", "error", "remedy"),
    [
        ('"controller.y_*"', '"controller.q_*"', WiringError, "q_*"),
        ('"controller.u_d"', '"controller.u"', WiringError, "no input"),
        ('"plant.x_*" = true', '"plant.z*" = true', WiringError, "record"),
        (CONTINUOUS_STEP, "[components.controller]", ScenarioError, "continuous"),
        ('sets = "controller"', 'sets = "plant"', DesignError, "K_x1"),
        ('m_1 = "plant.m_1"', 'm_1 = "plant.m_9"', ScenarioError, "m_9"),
        ('"controller.u" = "1 kHz"', "", ScenarioError, '"controller.u" = true'),
        ('unit = "um"', 'unit = "V"', ScenarioError, "metrics.tracking"),
        ('"plant.r_g"', '"plant.r_q"', ScenarioError, "'r_g'"),
        ("plants.ball_screw.two_mass", "their.fmu", FmuError, "their.fmu"),
        ("plants.ball_screw.two_mass", "model.py", ScenarioError, "model.py"),
        ("plants.ball_screw.two_mass", "plants.bal", BuildError, "plants.bal"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_before_the_run(
    drive, tmp_path, old, new, error, remedy
):
    assert old in DRIVE
    drive.write_text(DRIVE.replace(old, new, 1))
    with pytest.raises(error) as refusal:
        run(drive, tmp_path / "out")
    assert str(drive) in str(refusal.value)
    assert remedy in str(refusal.value)
    assert not (tmp_path / "out/result").exists()


def test_a_folder_that_holds_other_things_is_left_alone(drive, tmp_path):
    (tmp_path / "home").mkdir()
    (tmp_path / "home/thesis.tex").touch()
    with pytest.raises(ScenarioError, match="another folder"):
        run(load_scenario(drive), tmp_path / "home")


def test_a_design_can_take_signals_of_an_earlier_run(drive, tmp_path):
    child = tmp_path / "child.toml"
    child.write_text(
        'base = "drive.toml"\n[design.prefilter]\n'
        'call = "controllers.synthesis.prefilter:identify"\nfrom_run = "drive"\n'
        'signals = { x_r = "trajectory.x_r", y_2 = "plant.x_2" }\nsets = "controller"\n'
    )
    parameters = composed(child).system.components["controller"].parameters
    assert parameters["K_acc"] != 0.0


def test_a_design_that_needs_its_own_run_is_refused(drive, tmp_path):
    child = tmp_path / "child.toml"
    child.write_text(
        'base = "drive.toml"\n[design.prefilter]\n'
        'call = "controllers.synthesis.prefilter:identify"\nfrom_run = "child"\n'
        'signals = { x_r = "trajectory.x_r", y_2 = "plant.x_2" }\nsets = "controller"\n'
    )
    with pytest.raises(ScenarioError, match="its own run"):
        composed(child)


def test_the_package_offers_its_public_names():
    for name in orchestrator.__all__:
        assert getattr(orchestrator, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute"):
        _ = orchestrator.simulat


EXPECTING = [
    f"{study.name}/{name}"
    for study in sorted(STUDIES.glob("*/"))
    for name, file in scenarios(study).items()
    if read_scenario(file).get("expect")
]


@pytest.mark.parametrize("name", EXPECTING)
def test_a_scenario_meets_its_own_expectations(name, tmp_path):
    done = run(name, tmp_path, report=False)
    assert [check.text for check in done.checks if not check.met] == []
    assert done.diverged is None
