"""What another FMU takes over from the component whose place it takes."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.result import Result
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.override import parse_swaps
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import execute, run_earlier
from orchestrator.supplied import build_supplied

DRIVE = """\
stop = "0.02"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/20000"
parameters = { m_2 = 0.5e-3, m_12 = 1e-6, r_g = 3.0e-3 }
start = { d_2 = 0.25, "state.x_1" = 0.1 }
[connections]
"plant.u" = 1.0
[record]
"plant.x_2" = true
"plant.x_t" = true
"plant.v_2" = true
[metrics]
far = { kind = "max", of = "plant.x_t", unit = "um" }
fast = { kind = "max", of = "plant.v_2", unit = "m/s", scale = "plant.r_g" }
[expect]
"far.max" = { above = 1e-6, below = 1, unit = "m" }
"""
MAP = """\
u = { name = "motor_voltage", gain = -1 }
d_2 = "table_force"
m_2 = "inertia_table"
x_2 = { name = "table", gain = 0.3141592653589793, unit = "rad" }
v_2 = { name = "table_speed", gain = 0.3141592653589793, unit = "rad/s" }
x_t = "table"
r_g = "lead"
"""


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario file with the supplied FMU beside it."""
    file = tmp_path_factory.mktemp("drive") / "drive.toml"
    file.write_text(DRIVE)
    build_supplied("supplied.ball_screw", file.parent)
    return file


def swapped(drive: Path, maps: str, *overrides: str) -> Composition:
    def no_run(name: str) -> None:
        raise AssertionError(name)

    tables = parse_swaps([f"plant={drive.parent / 'ball_screw.fmu'}"], [maps])
    return compose(load_scenario(drive, overrides, tables), no_run)


def test_values_carry_over_by_map_in_our_unit_and_the_rest_is_named(drive: Path):
    found = swapped(drive, MAP)
    plant = found.system.components["plant"]
    assert plant.parameters == {"m_2": 0.5e-3, "r_g": 3.0e-3}
    assert plant.start == {"d_2": 0.25, "u": 1.0}
    assert [(left.name, left.value, left.unit) for left in found.not_taken_over] == [
        ("plant.m_12", 1e-6, "V.s2/rad"),
        ("plant.state.x_1", 0.1, "rad"),
    ]
    assert [str(left) in found.warnings for left in found.not_taken_over] == [True] * 2
    assert "has no variable 'm_12'; name it in the map" in found.warnings[0]


def test_the_order_is_scenario_then_map_then_set(drive: Path):
    mass = 'm_2 = { name = "inertia_table", value = 0.6e-3 }'
    given = MAP.replace('m_2 = "inertia_table"', mass)
    assert swapped(drive, given).parameter("plant.m_2").value == 0.6e-3
    last = swapped(drive, given, "plant.m_2=0.7e-3")
    assert last.parameter("plant.m_2").value == 0.7e-3


def test_a_variable_of_theirs_alone_is_set_in_its_own_unit(drive: Path):
    warm = 'hall = { name = "ambient", value = "300 K" }\n'
    found = swapped(drive, MAP + warm)
    assert found.parameter("plant.hall").value == pytest.approx(26.85)


def test_recorded_and_judged_in_our_unit(drive: Path, tmp_path: Path):
    swap = ("--swap", f"plant={drive.parent / 'ball_screw.fmu'}", "--map", MAP)
    result = CliRunner().invoke(
        app, ["run", str(drive), *swap, "-o", str(tmp_path / "run"), "--json"]
    )
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["metrics"]["far.max"]["unit"] == "um"
    assert told["metrics"]["far.max"]["value"] > 100
    assert [left["name"] for left in told["not_taken_over"]] == [
        "plant.m_12",
        "plant.state.x_1",
    ]
    signals = Result(tmp_path / "run")
    assert {n: str(signals[n].unit) for n in signals} == {
        "plant.x_2": "rad",
        "plant.x_t": "m",
        "plant.v_2": "rad/s",
    }
    assert signals["plant.x_t"].values[-1] == pytest.approx(
        signals["plant.x_2"].values[-1] * 0.020 / (2 * 3.141592653589793)
    )
    page = (tmp_path / "run/report.html").read_text()
    assert "plant.m_12 = 1e-06 V.s2/rad is not taken over" in page


def test_the_table_of_both_names_what_is_left(drive: Path, tmp_path: Path):
    swap = ("--swap", f"plant={drive.parent / 'ball_screw.fmu'}", "--map", MAP)
    result = CliRunner().invoke(
        app, ["run", str(drive), *swap, "-o", str(tmp_path / "run")]
    )
    lines = [line.split() for line in result.stdout.splitlines()]
    (row,) = [line for line in lines if line[:1] == ["plant.m_12"]]
    assert row[:5] == ["plant.m_12", "1e-06", "not", "taken", "over"]


@pytest.mark.parametrize(
    ("replaced", "by", "said"),
    [
        (
            'x_2 = { name = "table", gain = 0.3141592653589793, unit = "rad" }',
            'x_2 = "table"',
            'x_2: mm cannot become rad.*with unit = "rad"',
        ),
        ('d_2 = "table_force"', 'd_2 = "ambient"', "d_2: V cannot become degC"),
        ('m_2 = "inertia_table"', 'm_2 = "inertia"', "has no such variable"),
        ("gain = -1", "gain = 0", "0.0 is no gain"),
        (
            'r_g = "lead"',
            'r_g = { name = "lead", unit = "kg" }',
            "kg cannot become mm/rev",
        ),
    ],
)
def test_a_map_that_cannot_be_is_refused(drive: Path, replaced, by, said):
    with pytest.raises((ScenarioError, WiringError), match=said):
        swapped(drive, MAP.replace(replaced, by))


def test_what_is_set_must_be_there(drive: Path):
    with pytest.raises(WiringError, match="no variable 'm_12'"):
        swapped(drive, MAP, "plant.m_12=2e-6")


@pytest.mark.parametrize(("sign", "warned"), [(-1, False), (1, True)])
def test_a_pulse_tells_a_sign_that_the_map_lacks(
    drive: Path, tmp_path: Path, sign: int, warned: bool
):
    driven = tmp_path / "driven.toml"
    text = DRIVE.replace('"plant.u" = 1.0', '"plant.u" = "sine.d"')
    sine = '[components.sine]\nfmu = "plants.disturbances.sine"\nstep = "1/20000"\n'
    driven.write_text(text.replace("[connections]", f"{sine}[connections]"))
    maps = MAP.replace("gain = -1", f"gain = {sign}")
    swap = ("--swap", f"plant={drive.parent / 'ball_screw.fmu'}", "--map", maps)
    run = ["run", str(driven), *swap, "-o", str(tmp_path / "run"), "--json"]
    told = json.loads(CliRunner().invoke(app, run).stdout)
    answers = {(a["input"], a["output"]): a["ratio"] for a in told["answers"]}
    # not quite 1: m_12 is left, and the map's gains are those of another lead
    assert answers == {
        ("plant.u", f"plant.{name}"): pytest.approx(-sign, rel=0.1)
        for name in ("x_2", "v_2", "x_t")
    }
    said = "plant.x_2 answers a pulse on plant.u the other way round"
    assert any(said in warning for warning in told["warnings"]) is warned
    page = (tmp_path / "run/report.html").read_text()
    assert (said in page) is warned
    metrics = json.loads((tmp_path / "run/metrics.json").read_text())
    assert any(said in warning for warning in metrics["warnings"]) is warned


SPRING = '''"""A sampled spring. Source: none, a test (2026)."""
from typing import Annotated, NamedTuple
import numpy as np
from numpy.typing import NDArray
from fmus.model import Sampled, Var
class State(NamedTuple):
    n: Annotated[float, Var("1", "count")] = 0.0
class Input(NamedTuple):
    u: Annotated[float, Var("{length}", "way")] = 0.0
class Output(NamedTuple):
    y: Annotated[float, Var("N", "force")]
    w: Annotated[NDArray[np.float64], Var("{length}", "ways")]
class Parameters(NamedTuple):
    {k}: Annotated[float, Var("N/{length}", "stiffness")] = 1.0
    v: Annotated[NDArray[np.float64], Var("{length}", "ways")] = np.array([1.0, 2.0])
def step(x, u, p, T_s):
    """y = k (u + v_1)."""
    return State(x.n + 1), Output(p.{k} * (u.u + p.v[0]), u.u + p.v)
model = Sampled("Spring", step, State(), Input(), Parameters())
'''
SPRUNG = """\
stop = "1/100"
fmi = {fmi}
[components.g]
fmu = "old.py"
step = "1/1000"
parameters = {{ k = 2000, v = [0.003, 0.0] }}
[connections]
"g.u" = 0.001
[record]
"g.y" = true
"g.w" = true
"""


def springs(folder: Path, fmi: int, more: str = "") -> Path:
    """Write k (u + v_1) of metres, and springs whose FMUs are in millimetres."""
    forms = (("old", "m", "k"), ("new", "mm", "stiff"), ("same", "mm", "k"))
    for name, length, k in forms:
        text = SPRING.replace("{length}", length).replace("{k}", k)
        (folder / f"{name}.py").write_text(text)
    (folder / "s.toml").write_text(SPRUNG.format(fmi=fmi) + more)
    return folder / "s.toml"


def sprung(folder: Path, fmi: int, maps: str, *sets: str) -> Result:
    """Run the spring of metres by that of millimetres."""
    file = springs(folder, fmi)
    tables = parse_swaps([f"g={folder / 'new.py'}"], [maps])
    scenario = load_scenario(file, sets, tables)
    return execute(compose(scenario, run_earlier), folder / "run", report=False)


STIFF = 'k = {name = "stiff", unit = "N/mm"}'


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("maps", "sets", "force"),
    [
        ('k = "stiff"', (), 8.0),
        (STIFF, (), 8.0),
        ('k = "stiff", u = {name = "u", unit = "mm"}', (), 8.0),
        ('k = "stiff", v = {name = "v", unit = "mm"}', (), 8.0),
        ('k = {name = "stiff", unit = "N/mm", value = 3}', (), 12.0),
        ('k = {name = "stiff", value = 3000}', (), 12.0),
        (STIFF, ("g.k=1000",), 4.0),
        (STIFF, ("g.k=3 N/mm",), 12.0),
        (STIFF, ("g.v=[0.001, 0]",), 4.0),
    ],
)
def test_a_number_of_the_scenario_means_the_unit_it_was_written_in(
    tmp_path: Path, fmi: int, maps: str, sets: tuple[str, ...], force: float
):
    found = sprung(tmp_path, fmi, maps, *sets)
    assert found["g.y"].values[-1] == pytest.approx(force)


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_array_keeps_our_unit(tmp_path: Path, fmi: int):
    found = sprung(tmp_path, fmi, 'k = "stiff"')
    assert [found[f"g.w[{i}]"].unit for i in (1, 2)] == ["m", "m"]
    assert found["g.w[1]"].values[-1] == pytest.approx(0.004)


def test_a_number_that_cannot_be_had_in_the_unit_of_the_map_is_refused(tmp_path: Path):
    said = r"components\.g\.parameters\.k = 2000: N/m cannot become kg"
    with pytest.raises(ScenarioError, match=said):
        sprung(tmp_path, 2, 'k = {name = "stiff", gain = 1, unit = "kg"}')


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(("more", "force"), [((), 8.0), (("g.k=1000",), 4.0)])
def test_an_fmu_that_is_set_takes_numbers_in_the_unit_they_were_written_in(
    tmp_path: Path, fmi: int, more: tuple[str, ...], force: float
):
    file = springs(tmp_path, fmi)
    scenario = load_scenario(file, (f"g.fmu={tmp_path / 'same.py'}", *more))
    found = execute(compose(scenario, run_earlier), tmp_path / "run", report=False)
    assert found["g.y"].values[-1] == pytest.approx(force)
    assert found["g.w[1]"].unit == "m"


def test_a_fault_in_a_unit_that_the_map_replaces_is_refused(tmp_path: Path):
    fault = '[faults]\n"g.u" = { kind = "bias", value = 0.001 }\n'
    file = springs(tmp_path, 2, fault)
    driver = '[components.h]\nfmu = "old.py"\nstep = "1/1000"\n[connections]'
    text = file.read_text().replace("[connections]", driver)
    file.write_text(text.replace('"g.u" = 0.001', '"g.u" = "h.w[1]"'))

    def swapped(maps: str) -> None:
        tables = parse_swaps([f"g={tmp_path / 'new.py'}"], [maps])
        compose(load_scenario(file, (), tables), run_earlier)

    swapped('k = "stiff"')
    with pytest.raises(ScenarioError, match=r'faults\."g\.u": its value is in m'):
        swapped('k = "stiff", u = { name = "u", unit = "mm" }')
