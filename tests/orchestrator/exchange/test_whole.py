"""A composition as one FMU shows in FMPy what ``run`` records, bit for bit."""

import zipfile
from fractions import Fraction
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.whole.export import export_whole
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

MODELS = Path(__file__).parents[1] / "models"
SMALL = Path(__file__).parents[2] / "fmus" / "small_models"
THREE_RATES = f"""
stop = "1/10"
[components.tone]
fmu = "controllers.references.sine"
step = "1 kHz"
offset = "1/3000"
latency = 2
parameters = {{ frequency_hz = 20 }}
map = {{ x_r = {{ name = "x_r", gain = 300, offset = 0.1, unit = "V" }} }}
[components.late]
fmu = "{SMALL / "late.py"}"
step = "1/4000"
[components.pi]
fmu = "{SMALL / "pi.py"}"
step = "1/1500"
map = {{ y = {{ name = "y", gain = 2, unit = "V" }} }}
[connections]
"late.u" = "tone.x_r"
"pi.y" = "late.y"
[record]
"late.y" = "1/12000"
"pi.u" = "1/12000"
"tone.x_r" = "1/12000"
"""
CIRCLE = f"""
stop = "1"
[components.a]
fmu = "{MODELS / "integrator.py"}"
step = "1/10"
parameters = {{ g = 0.5 }}
start = {{ "state.x" = 1.0 }}
[components.b]
fmu = "{MODELS / "integrator.py"}"
step = "1/10"
parameters = {{ g = 0.5 }}
start = {{ "state.x" = 2.0 }}
[connections]
"a.u" = "b.z"
"b.u" = "a.z"
[record]
"a.z" = true
"b.z" = true
"""


class Slave:
    """An FMU in FMPy, its variables by name."""

    def __init__(self, file: Path, folder: Path) -> None:
        self.description = fmpy.read_model_description(str(file))
        place = fmpy.extract(str(file), str(folder))
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=place,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="whole",
        )
        self.fmu.instantiate()
        variables = self.description.modelVariables
        self.references = {v.name: v.valueReference for v in variables}
        self.outputs = [v.name for v in variables if v.causality == "output"]

    def begin(self, **values: float) -> None:
        self.fmu.setupExperiment()
        for name, value in values.items():
            self.fmu.setReal([self.references[name]], [value])
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def row(self) -> list[float]:
        found = self.fmu.getReal([self.references[n] for n in self.outputs])
        return [float(value) for value in found]

    def rows(self, step: Fraction, count: int, first: int = 0) -> list[list[float]]:
        found = [] if first else [self.row()]
        for k in range(first, count):
            self.fmu.doStep(float(k * step), float(step))
            found.append(self.row())
        return found


def exported(text: str, folder: Path, *sets: str, **ends: list[str]) -> Slave:
    file = folder / "scenario.toml"
    file.write_text(text)
    composition = compose(load_scenario(file, sets), run_earlier)
    made = export_whole(composition, folder / "whole.fmu", **ends)
    return Slave(made, folder / "unpacked")


@pytest.mark.parametrize(
    ("text", "step"), [(THREE_RATES, Fraction(1, 12000)), (CIRCLE, Fraction(1, 10))]
)
def test_rows_are_those_of_the_run(text: str, step: Fraction, tmp_path: Path) -> None:
    whole = exported(text, tmp_path)
    whole.begin()
    done = run(tmp_path / "scenario.toml", tmp_path / "run", report=False)
    names = whole.outputs
    found = np.array(whole.rows(step, len(done[names[0]].values) - 1)).T
    for name, values in zip(names, found, strict=True):
        np.testing.assert_array_equal(values, done[name].values)


def test_parameters_are_set_by_component_and_name(tmp_path: Path) -> None:
    changed = "tone.frequency_hz=33", "late.T=0.004"
    whole = exported(THREE_RATES, tmp_path)
    whole.begin(**{"tone.frequency_hz": 33, "late.T": 0.004})
    scenario = load_scenario(tmp_path / "scenario.toml", changed)
    done = run(scenario, tmp_path / "run", report=False)
    found = np.array(whole.rows(Fraction(1, 12000), 1200)).T
    for name, values in zip(whole.outputs, found, strict=True):
        np.testing.assert_array_equal(values, done[name].values)


def test_a_state_goes_on_in_another_instance(tmp_path: Path) -> None:
    whole = exported(THREE_RATES, tmp_path)
    whole.begin()
    step = Fraction(1, 12000)
    whole.rows(step, 345)
    state = whole.fmu.serializeFMUstate(whole.fmu.getFMUState())
    expected = whole.rows(step, 600, 345)
    other = Slave(tmp_path / "whole.fmu", tmp_path / "other")
    other.begin()
    other.fmu.setFMUState(other.fmu.deSerializeFMUstate(state))
    assert other.rows(step, 600, 345) == expected


def test_nanoseconds_lose_no_tick(tmp_path: Path) -> None:
    """12 kHz by a master that steps 83,333 ns: exactly one tick per step."""
    whole = exported(THREE_RATES, tmp_path)
    whole.begin()
    expected = whole.rows(Fraction(1, 12000), 1200)
    whole.fmu.reset()
    whole.begin()
    assert whole.rows(Fraction(83_333, 10**9), 1200) == expected


def test_steps_shorter_than_a_tick_are_not_lost(tmp_path: Path) -> None:
    """Two thousand steps of a two-thousandth of a tick are one tick."""
    whole = exported(THREE_RATES, tmp_path)
    whole.begin()
    expected = whole.rows(Fraction(1, 12000), 2)[-1]
    whole.fmu.reset()
    whole.begin()
    assert whole.rows(Fraction(1, 24_000_000), 4000)[-1] == expected


def test_an_outside_input_acts_at_the_step_it_is_set(tmp_path: Path) -> None:
    """A tone given from outside to a continuous part equals the tone inside."""
    text = THREE_RATES.replace('offset = "1/3000"\nlatency = 2\n', "")
    text = text.replace('step = "1/4000"', 'step = "1 kHz"')
    (tmp_path / "scenario.toml").write_text(text)
    done = run(tmp_path / "scenario.toml", tmp_path / "run", report=False)
    given, expected = (done[n].values[::12] for n in ("tone.x_r", "late.y"))
    ends = {"inputs": ["late.u"], "outputs": ["late.y"]}
    whole = exported(text, tmp_path, "connections.late.u=false", **ends)
    variables = whole.description.modelVariables
    (described,) = [v for v in variables if v.causality == "input"]
    assert "acts from the step it is set" in described.description
    whole.begin(**{"late.u": float(given[0])})
    found = [whole.row()[0]]
    for k, value in enumerate(given[:-1]):
        whole.fmu.setReal([whole.references["late.u"]], [float(value)])
        whole.fmu.doStep(k * 1e-3, 1e-3)
        found += whole.row()
    np.testing.assert_array_equal(found, expected)


def test_what_cannot_be_compiled_in_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text(CIRCLE)
    composition = compose(load_scenario(file), run_earlier)
    with pytest.raises(ScenarioError, match=r"b\.z drives it"):
        export_whole(composition, tmp_path / "x.fmu", inputs=["a.u"])
    with pytest.raises(ScenarioError, match="no component 'c'"):
        export_whole(composition, tmp_path / "x.fmu", outputs=["c.z"])
    faulty = CIRCLE + '[faults]\n"a.u" = { kind = "bias", value = 1 }\n'
    file.write_text(faulty)
    composition = compose(load_scenario(file), run_earlier)
    with pytest.raises(ScenarioError, match="faults are not compiled"):
        export_whole(composition, tmp_path / "x.fmu")


def test_the_command_line_exports_one_fmu(tmp_path: Path) -> None:
    (tmp_path / "circle.toml").write_text(CIRCLE)
    target = tmp_path / "loop.fmu"
    asked = ["export", str(tmp_path / "circle.toml"), "-o", str(target)]
    done = CliRunner().invoke(app, [*asked, "--outputs", "a.z"])
    assert done.exit_code == 0, done.output
    with zipfile.ZipFile(target) as archive:
        assert any(n.startswith("binaries/") for n in archive.namelist())
    assert CliRunner().invoke(app, [*asked, "--fmi", "3"]).exit_code == 2
    assert CliRunner().invoke(app, [*asked, "--at", "1 kHz"]).exit_code == 2
