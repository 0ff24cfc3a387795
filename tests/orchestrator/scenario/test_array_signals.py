"""Arrays of signals are connected and recorded whole, in either version of FMI."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from fmus.build import load_model
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

MODEL = Path(__file__).parents[2] / "fmus" / "small_models" / "scheduled.py"
SCENARIO = """
stop = "0.01"
fmi = {fmi}
[components.first]
fmu = "{model}"
step = "1/1000"
[components.second]
fmu = "{model}"
step = "1/1000"
[connections]
"second.u" = "first.y"
[record]
"first.y" = true
"second.u[2]" = true
"second.last" = true
"""


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_array_of_signals_is_connected_as_a_whole(tmp_path: Path, fmi: int) -> None:
    file = tmp_path / "arrays.toml"
    file.write_text(SCENARIO.format(fmi=fmi, model=MODEL.as_posix()))
    result = run(load_scenario(str(file)), tmp_path / "run", report=False)
    model = load_model(str(MODEL))
    p, u = model.parameters, model.input.u
    A, B = ((M[0:3] + M[3:6]) / 2 for M in (p.A, p.B))  # at 0.25, between 0.2 and 0.3
    steady = -np.linalg.solve(A, B @ u)
    y = [p.C @ (steady - expm(A * k * 1e-3) @ steady) for k in range(11)]
    for i in (0, 1):
        got = result[f"first.y[{i + 1}]"].values
        assert got == pytest.approx([row[i] for row in y], rel=1e-6, abs=1e-12)
    second = result["second.u[2]"].values
    assert second == pytest.approx([row[1] for row in y], rel=1e-6, abs=1e-12)
    assert result["second.last"].values[-1] != 0
