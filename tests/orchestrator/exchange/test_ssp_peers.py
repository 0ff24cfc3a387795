"""Packages of ours in tools of others, as far as they read SSP (docs/ssp.md)."""

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from numpy.typing import NDArray
from wholes import SMALL, composed

from fmus.build import build
from orchestrator.exchange.ssp.write import export_ssp
from orchestrator.fmu.description import read_fmu
from orchestrator.peers import environment
from orchestrator.peers.ecospy_tool import __file__ as ecospy_tool
from orchestrator.session import run

COUNTER = Path(__file__).parents[1] / "models" / "counter.py"
COUNTERS = f"""
stop = "1/50"
[components.a]
fmu = "{COUNTER}"
step = "1/1000"
latency = 1
[components.b]
fmu = "{COUNTER}"
step = "1/1000"
latency = 1
[connections]
"b.u" = "a.k"
[record]
"b.seen" = true
"""
TONE = f"""
stop = "1/20"
[components.tone]
fmu = "controllers.references.sine"
step = "1/1000"
latency = 1
parameters = {{ frequency_hz = 20, amplitude = 0.003 }}
map = {{ x_r = {{ name = "x_r", gain = 300, offset = 0.1, unit = "V" }} }}
[components.late]
fmu = "{SMALL / "late.py"}"
step = "1/1000"
parameters = {{ T = 0.004 }}
[connections]
"late.u" = "tone.x_r"
[record]
"late.y" = true
"""
LIBCOSIM = """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
execution = CosimExecution.from_ssp_file(ssp)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
slaves = {info.name.decode(): info.index for info in execution.slave_infos()}
for _ in range(steps):
    assert execution.step()
    values = observer.last_real_values(slaves[component], [reference])
    found.append(float(values[0]))
"""
ECOS = """
from runpy import run_path
run_path(tool)["_load_tbb"]()
from ecospy import EcosSimulation
with EcosSimulation(step_size=1e-3, ssp_path=ssp) as simulation:
    assert simulation.init()
    for _ in range(steps):
        simulation.step(1)
        found.append(simulation.get_real(f"{component}::{variable}"))
    simulation.terminate()
"""
CONTAINER = """
from pathlib import Path
from fmu_manipulation_toolbox.assembly import Assembly
made = Assembly(Path(ssp).name, fmu_directory=Path(ssp).parent, default_step_size=1e-3)
made.make_fmu()
found.append(len(made.root.fmu_names_list))
"""


def told(peer: str, text: str, **given: Any) -> list[float]:
    """Return what a few lines in the Python of a tool find."""
    try:
        python = environment.install(environment.PEERS[peer])
    except environment.PeerError as error:
        pytest.skip(str(error))
    lines = [f"{name} = {value!r}" for name, value in given.items()]
    lines += [
        "found = []",
        text,
        "import json, sys; print(json.dumps(found), file=sys.stderr)",
    ]
    done = subprocess.run(
        [str(python), "-c", "\n".join(lines)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found: list[float] = json.loads(
        re.findall(r"^\[[\d., e+-]+\]$", done.stderr, re.M)[-1]
    )
    return found


def ours(text: str, signal: str, folder: Path) -> tuple[NDArray[np.float64], str]:
    """Return the rows of our run, and the package."""
    file = folder / "scenario.toml"
    file.write_text(text)
    done = run(file, folder / "run", report=False)
    package = export_ssp(composed(file), folder / "it.ssp", "1.0")
    return np.asarray(done[signal].values, float), str(package)


def test_libcosim_takes_values_transformations_and_steps(tmp_path: Path) -> None:
    expected, ssp = ours(TONE, "late.y", tmp_path)
    described = read_fmu(build(str(SMALL / "late.py")))
    given = {"component": "late", "reference": described["y"].reference}
    found = told("libcosimpy", LIBCOSIM, ssp=ssp, steps=50, **given)
    assert (
        np.abs(np.array(found) - expected[1:]).max() <= 4e-16 * np.abs(expected).max()
    )


def test_ecos_runs_what_needs_no_values(tmp_path: Path) -> None:
    expected, ssp = ours(COUNTERS, "b.seen", tmp_path)
    given = {"component": "b", "variable": "seen", "steps": 20}
    found = told("ecospy", ECOS, ssp=ssp, tool=ecospy_tool, **given)
    np.testing.assert_array_equal(found, expected[1:])


def test_fmpy_runs_what_needs_no_values(tmp_path: Path) -> None:
    expected, ssp = ours(COUNTERS, "b.seen", tmp_path)
    found = simulate_ssp(ssp, stop_time=0.0195, step_size=1e-3)
    np.testing.assert_array_equal(found["b.seen"], expected[1:])


def test_fmucontainer_makes_one_fmu_of_it(tmp_path: Path) -> None:
    _, ssp = ours(COUNTERS, "b.seen", tmp_path)
    assert told("fmucontainer", CONTAINER, ssp=ssp) == [2]
    assert (tmp_path / "it.fmu").is_file()
