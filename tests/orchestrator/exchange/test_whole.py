"""A composition as one FMU shows in FMPy what ``run`` records, bit for bit."""

import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner
from wholes import CIRCLE, SMALL, THREE_RATES, Slave, composed, exported

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.whole.export import export_whole
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

MODELS = Path(__file__).parents[1] / "models"
FAULTS = """
[faults]
"late.u" = [
    { kind = "delay", samples = 2, window = ["0.01", "0.1"] },
    { kind = "bias", value = 3, window = ["0.0201", "0.05"] },
]
"pi.y" = { kind = "stuck", window = ["1/30", "0.07"] }
"""


@pytest.mark.parametrize(
    ("text", "step"),
    [
        (THREE_RATES, Fraction(1, 12000)),
        (THREE_RATES + FAULTS, Fraction(1, 12000)),
        (CIRCLE, Fraction(1, 10)),
        (CIRCLE.replace("g = 0.5", "g = 2.0"), Fraction(1, 10)),
    ],
    ids=["rates", "faults", "circle", "Newton"],
)
def test_rows_are_those_of_the_run(text: str, step: Fraction, tmp_path: Path) -> None:
    wholes = exported(text, tmp_path), exported(text, tmp_path, fmi=3)
    done = run(tmp_path / "scenario.toml", tmp_path / "run", report=False)
    for whole in wholes:
        whole.begin()
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
        whole.set("late.u", float(value))
        whole.step(k, Fraction(1, 1000))
        found += whole.row()
    np.testing.assert_array_equal(found, expected)


def test_what_cannot_be_compiled_in_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text(CIRCLE)
    composition = composed(file)
    with pytest.raises(ScenarioError, match=r"b\.z drives it"):
        export_whole(composition, tmp_path / "x.fmu", inputs=["a.u"])
    with pytest.raises(ScenarioError, match="no component 'c'"):
        export_whole(composition, tmp_path / "x.fmu", outputs=["c.z"])
    often = CIRCLE.replace('"1/10"', '"1/100003"', 1)
    file.write_text(often)
    with pytest.raises(ScenarioError, match=r"rates .* repeats after more than"):
        export_whole(composed(file), tmp_path / "x.fmu")


MATRICES = f"""
stop = "0.01"
fmi = FMI
[components.n]
fmu = "{SMALL / "matrices.py"}"
step = "1 kHz"
[components.m]
fmu = "{SMALL / "matrices.py"}"
step = "1 kHz"
map = {{ w = {{ name = "u[1]", gain = 2, unit = "V" }} }}
[connections]
SINK = SOURCE
[record]
"m.y" = true
"""
NOT_FREE = {
    "an element of an array that is driven": ("m.u", "n.y", ["m.u[2]"], "n.y drives"),
    "our name of an element": ("m.w", "n.passed", ["m.u[1]"], "n.passed drives it"),
    "the element of our name": ("m.u[1]", "n.passed", ["m.w"], "n.passed drives it"),
    "one input twice": ("n.u[1]", "m.passed", ["m.w", "m.u[1]"], "the same input as"),
}


@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("case", NOT_FREE)
def test_an_input_that_is_driven_by_whatever_name_is_not_offered_outside(
    case: str, fmi: str, tmp_path: Path
) -> None:
    sink, source, inputs, why = NOT_FREE[case]
    text = MATRICES.replace("FMI", fmi).replace("SINK", f'"{sink}"')
    with pytest.raises(ScenarioError, match=why):
        exported(text.replace("SOURCE", f'"{source}"'), tmp_path, inputs=inputs)


def test_an_array_of_fmi_3_is_not_driven_in_part_from_outside(tmp_path: Path) -> None:
    """By FMI 2, whose elements are variables, it can be."""
    text = MATRICES.replace("SINK", '"m.u[1]"').replace("SOURCE", '"n.passed"')
    with pytest.raises(ScenarioError, match="build m as fmi = 2"):
        exported(text.replace("FMI", "3"), tmp_path, inputs=["m.u[2]"])
    whole = exported(text.replace("FMI", "2"), tmp_path, inputs=["m.u[2]"])
    whole.begin()
    before = whole.row()
    whole.set("m.u[2]", 10.0)
    whole.rows(Fraction(1, 1000), 3)
    assert whole.row()[1] > before[1] + 1


def test_what_is_recorded_and_set_too_is_one_variable(tmp_path: Path) -> None:
    """A parameter, an input, a state: FMI wants names to be unique."""
    extra = '"pi.K_p" = true\n"pi.r" = true\n"pi.state.q" = true\n'
    whole = exported(THREE_RATES + extra, tmp_path, inputs=["pi.r"])
    found = {v.name: v.causality for v in whole.description.modelVariables}
    assert len(found) == len(whole.description.modelVariables)
    kinds = [found[f"pi.{name}"] for name in ("K_p", "r", "state.q")]
    assert kinds == ["parameter", "input", "output"]


def test_the_command_line_exports_one_fmu(tmp_path: Path) -> None:
    (tmp_path / "circle.toml").write_text(CIRCLE)
    target = tmp_path / "loop.fmu"
    asked = ["export", str(tmp_path / "circle.toml"), "-o", str(target)]
    done = CliRunner().invoke(app, [*asked, "--outputs", "a.z"])
    assert done.exit_code == 0, done.output
    with zipfile.ZipFile(target) as archive:
        assert any(n.startswith("binaries/") for n in archive.namelist())
    assert CliRunner().invoke(app, [*asked, "--fmi", "3"]).exit_code == 0
    assert CliRunner().invoke(app, [*asked, "--fmi", "1"]).exit_code == 2
    assert CliRunner().invoke(app, [*asked, "--at", "1 kHz"]).exit_code == 2
