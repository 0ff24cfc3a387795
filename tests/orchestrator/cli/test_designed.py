"""`build SCENARIO:component` packs a component as that scenario runs it."""

import json
import re
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from systems import SMALL
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

SCENARIO = "ball_screw_pole_placement/mc_ppc_track_500"
PARTS = ("trajectory", "plant", "encoder", "controller")  # in the order of the signal
ROWS = 15_013


class Part:
    """An FMU in plain FMPy; nothing but its inputs is ever set."""

    def __init__(self, file: str, folder: Path) -> None:
        described = fmpy.read_model_description(file)
        self.references = {v.name: v.valueReference for v in described.modelVariables}
        self.slave = FMU2Slave(
            guid=described.guid,
            unzipDirectory=fmpy.extract(file, folder),
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="part",
        )
        self.slave.instantiate()
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def take(self, **values: float) -> None:
        references = [self.references[name] for name in values]
        self.slave.setReal(references, list(values.values()))

    def give(self, *names: str) -> list[float]:
        return list(self.slave.getReal([self.references[name] for name in names]))


def build(*arguments: str) -> str:
    done = CliRunner().invoke(app, ["build", "--json", *arguments])
    assert done.exit_code == 0, done.output
    return str(json.loads(done.stdout)["fmus"][0]["file"])


def test_designed_parts_in_a_foreign_loop_give_the_designed_motion(tmp_path):
    ours = run(load_scenario(SCENARIO), tmp_path / "run")
    parts = {
        name: Part(build(f"{SCENARIO}:{name}", "-o", str(tmp_path)), tmp_path / name)
        for name in PARTS
    }
    trajectory, plant, encoder, controller = parts.values()
    T, x_2, u = 1 / 20_000, [], controller.give("u")[0]
    command = ("x_r", "v_r", "a_r", "j_r", "s_r")
    for k in range(ROWS):
        t = k * T
        if k:  # the control signal arrives one sample late, as in the scenario
            plant.take(u=u)
            plant.slave.doStep(t - T, T)
            u = controller.give("u")[0]
        x_2.append(plant.give("x_2")[0])
        encoder.take(**dict(zip(("x_1", "x_2"), plant.give("x_1", "x_2"), strict=True)))
        trajectory.slave.doStep(t, T)
        encoder.slave.doStep(t, T)
        measured = dict(zip(("y_1", "y_2"), encoder.give("y_1", "y_2"), strict=True))
        wanted = dict(zip(command, trajectory.give(*command), strict=True))
        controller.take(**measured, **wanted)
        controller.slave.doStep(t, T)
    assert np.array_equal(x_2, ours["plant.x_2"].values)


def test_a_component_of_a_lock_file_and_plain_c_carry_the_gains(tmp_path):
    run(load_scenario(SCENARIO), tmp_path / "run")
    lock = next((tmp_path / "run").rglob("scenario.lock.toml"))
    (gain,) = set(re.findall(r"\b632\.96529\d+", lock.read_text()))
    for name in (SCENARIO, str(lock)):
        folder = Path(build(f"{name}:controller", "--form", "c", "-o", str(tmp_path)))
        assert gain in (folder / "MCPPC.c").read_text()


MAPPED = f"""
stop = "1/100"
[components.pi]
fmu = "{SMALL / "pi.py"}"
step = "1 kHz"
parameters = {{ K_p = 300, I = 10 }}
start = {{ y = 0.5, r = 0.01 }}
[components.pi.map]
y = {{ name = "y", gain = 0.02, unit = "V" }}
K_p = {{ name = "K_p", gain = 0.001, unit = "V" }}
I = {{ name = "K_i", gain = 0.5, unit = "V" }}
[record]
"pi.u" = "1 kHz"
"""


def test_a_component_with_a_map_is_built_with_its_models_own_numbers(
    tmp_path, monkeypatch
):
    (tmp_path / "mapped.toml").write_text(MAPPED)
    monkeypatch.chdir(tmp_path)
    file = build("mapped.toml:pi", "--trust", "-o", str(tmp_path / "out"))
    start = {v.name: v.start for v in fmpy.read_model_description(file).modelVariables}
    given = [float(start[name]) for name in ("K_p", "K_i", "y", "r")]
    assert given == pytest.approx([0.3, 5.0, 0.01, 0.01], rel=1e-15)


def test_what_is_no_component_or_no_model_of_ours_is_refused():
    for name, said in (
        (f"{SCENARIO}:controler", "no component 'controler'"),
        ("no/such_scenario:controller", "no study"),
    ):
        done = CliRunner().invoke(app, ["build", name])
        assert done.exit_code == 2
        assert said in " ".join(done.output.split())
