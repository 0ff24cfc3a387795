"""FMUs of other people's exporters run here as they run alone."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from systems import system
from third_party import fmus_in, qfmu
from typer.testing import CliRunner

from fmus.compile import host_platform
from orchestrator.cli import app
from orchestrator.errors import FmuError
from orchestrator.fmu.description import read_fmu
from orchestrator.master.simulate import simulate
from orchestrator.result import Result
from orchestrator.session import run as run_scenario
from orchestrator.system import Component

pytestmark = pytest.mark.skipif(
    host_platform() != "linux-x86_64", reason="these FMUs hold linux64 binaries"
)


@pytest.fixture(scope="module")
def openmodelica(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs that OpenModelica exported, from the gemseo-fmu wheel."""
    folder = tmp_path_factory.mktemp("openmodelica")
    return fmus_in("gemseo-fmu==3.1.1", "linux", folder)


@pytest.mark.parametrize("period", ["1/100", "1/1000"])
def test_the_split_mass_spring_pair_equals_its_monolith(
    openmodelica: dict[str, Path], tmp_path: Path, period: str
) -> None:
    step = Fraction(period)
    names = ("MassSpringSubSystem1", "MassSpringSubSystem2", "MassSpringSystem")
    one, two, whole = (Component(n, openmodelica[n], step) for n in names)
    rows = {f"{n}.{x}": period for n, x in zip(names, ("x1", "x2", "x1"), strict=True)}
    wires = {f"{names[0]}.x2": f"{names[1]}.x2", f"{names[1]}.x1": f"{names[0]}.x1"}
    result = simulate(system("2", [one, two, whole], wires, rows), tmp_path)
    assert len(result[f"{names[0]}.x1"]) == 2 / step + 1
    np.testing.assert_array_equal(
        np.array(result[f"{names[0]}.x1"]), np.array(result[f"{names[2]}.x1"])
    )


def test_a_foreign_plant_runs_in_a_scenario_with_its_units(
    openmodelica: dict[str, Path], tmp_path: Path
) -> None:
    scenario = tmp_path / "damper.toml"
    scenario.write_text(
        f"""
stop = 1
[components.plant]
fmu = "{openmodelica["Mass_Damper"]}"
step = "1/1000"
[components.force]
fmu = "plants.disturbances.rope_snap"
step = "1/1000"
[components.plant.map]
pull = {{ name = "f", unit = "V", gain = 1 }}
[connections]
"plant.pull" = "force.d_2"
[record]
"plant.y" = true
"plant.damper.s_rel" = true
"""
    )
    done = run_scenario(scenario, tmp_path / "run", report=False)
    alone = fmpy.simulate_fmu(
        str(openmodelica["Mass_Damper"]),
        stop_time=1.0,
        step_size=1e-3,
        output_interval=1e-3,
        start_values={"f": 1.0},
        output=["y"],
        fmi_type="CoSimulation",
    )
    np.testing.assert_allclose(np.array(done["plant.y"]), alone["y"], atol=1e-13)
    assert done["plant.damper.s_rel"].unit == "m"


REGULATOR = """
stop = "1/4"
[components.force]
fmu = "plants.disturbances.rope_snap"
step = "1/2000"
[components.plant]
fmu = "plants.gantry.x_axis"
step = "1/2000"
parameters = { m_x = 0.5 }
[components.controller]
fmu = "controllers.xy_table.speed_pi"
step = "1/2000"
kind = "sampled"
latency = 1
[connections]
"plant.u" = "controller.u"
"plant.d" = "force.d_2"
"controller.v_est" = "plant.v"
[record]
"plant.x" = "1/2000"
"plant.v" = "1/2000"
"controller.u" = "1/2000"
"""
K_P, K_I = 0.006607, 0.12075  # V s/mm, V/mm: the model's own


@pytest.fixture
def regulator(tmp_path: Path) -> Path:
    file = tmp_path / "regulator.toml"
    file.write_text(REGULATOR)
    return file


def assert_equal(actual: Any, wanted: Any, scale: Any) -> None:
    """Compare to 1e-12 of the largest value of ``scale``."""
    largest = np.abs(np.array(scale)).max()
    assert largest > 0
    np.testing.assert_allclose(
        np.array(actual), np.array(wanted), rtol=0, atol=1e-12 * largest
    )


def swapped(
    regulator: Path, folder: Path, component: str, fmu: Path, map_: str
) -> tuple[Result, Result]:
    """Return original and swapped run, as the command line carries them out."""
    arguments = ["run", str(regulator), "-o", str(folder)]
    swap = ["--swap", f"{component}={fmu}", "--map", map_]
    done = CliRunner().invoke(app, [*arguments, *swap])
    assert done.exit_code == 0, done.output
    return Result(folder / "original"), Result(folder)


def test_a_pid_of_qfmu_takes_the_place_of_our_controller(
    regulator: Path, tmp_path: Path
) -> None:
    """Its forward Euler with the new input is our sum of backward rectangles."""
    pid = qfmu(tmp_path, "pid", "pid", kp=K_P, ki=K_I, dt=1 / 2000)
    names = (
        'v_est = {name = "u1", gain = -1, unit = "mm/s"}, '
        'u = {name = "y1", gain = 1, unit = "V"}'
    )
    ours, theirs = swapped(regulator, tmp_path / "run", "controller", pid, names)
    for name in ("controller.u", "plant.v", "plant.x"):
        assert_equal(theirs[name], ours[name], ours[name])


def test_a_state_space_of_qfmu_takes_the_place_of_our_plant(
    regulator: Path, tmp_path: Path
) -> None:
    """Euler's velocity of a mass is exact; its position lags by h v / 2."""
    matrices = {"A": "[[0,1],[0,0]]", "B": "[[0,0],[2,2]]"}
    plant = qfmu(tmp_path, "mass", "ss", **matrices, C="[[1,0],[0,1]]", dt=1e-3)
    names = (
        'u = {name = "u1", gain = 1, unit = "V"}, '
        'd = {name = "u2", gain = 1, unit = "V"}, '
        'x = {name = "y1", gain = 1, unit = "m"}, '
        'v = {name = "y2", gain = 1, unit = "m/s"}'
    )
    ours, theirs = swapped(regulator, tmp_path / "run", "plant", plant, names)
    for name in ("plant.v", "controller.u"):
        assert_equal(theirs[name], ours[name], ours[name])
    lag = np.array(ours["plant.x"]) - np.array(theirs["plant.x"])
    assert_equal(lag, np.array(ours["plant.v"]) / 2 / 2000, ours["plant.x"])


def test_a_pythonfmu3_fmu_runs_in_a_scenario(
    openmodelica: dict[str, Path], tmp_path: Path
) -> None:
    fmu = Component("theirs", openmodelica["FMU3Model"], Fraction(1, 100))
    names = [n for n, v in read_fmu(fmu.fmu).variables.items() if not v.shape]
    recorded = {f"theirs.{n}": "1/100" for n in names if n == "output"}
    result = simulate(system("1/10", [fmu], record=recorded), tmp_path)
    alone = fmpy.simulate_fmu(
        str(fmu.fmu), stop_time=0.1, step_size=0.01, output_interval=0.01
    )
    np.testing.assert_array_equal(np.array(result["theirs.output"]), alone["output"])


def test_a_missing_system_library_is_named(tmp_path: Path) -> None:
    here = Path.cwd()
    found = fmus_in("modestpy==0.1.1", "Simple2R1C_linux64", tmp_path)
    house = Component("house", found["Simple2R1C_linux64"], Fraction(1, 10))
    with pytest.raises(FmuError, match=r"libgfortran\.so\.3.*ldd"):
        simulate(system("1", [house]), tmp_path / "run")
    assert Path.cwd() == here
