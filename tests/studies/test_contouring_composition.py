"""Composed FMUs of the machining centre are an independent loop to 1e-9."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contouring_loop import PPI, Series, run
from contouring_space_loop import run as run_in_space

import controllers.three_axis
from orchestrator import session
from orchestrator.scenario.reading import load_scenario

FOLDER = Path(controllers.three_axis.__file__).parent
STOP = 1.2  # s: ramp, and a turn at full speed


def series() -> Series:
    return Series(json.loads((FOLDER / "k_planar.json").read_text()))


@pytest.mark.parametrize(
    ("scenario", "law", "T_s", "inertia"),
    [
        ("p_pi_rose", lambda: PPI(1e-3), 1e-3, (1.0, 1.0)),
        ("lpv_rose", series, 0.25e-3, (1.0, 1.2)),
    ],
)
def test_a_composition_is_the_independent_loop_to_1e_9(
    scenario: str, law: Any, T_s: float, inertia: tuple[float, float], tmp_path: Path
) -> None:
    changed = [f"stop={STOP}", f"plant.y.J_e={0.00979 * inertia[1]}"]
    loaded = load_scenario(f"contouring_lpv/{scenario}", changed)
    result = session.run(loaded, tmp_path, report=False)
    positions, commands = run(law(), T_s, STOP, inertia)
    got = {
        "plant.u_cx": positions[:, 0] + 0.05,
        "plant.u_cy": positions[:, 1],
        "controller.v_mx": commands[:, 0],
        "controller.v_my": commands[:, 1],
    }
    for signal, expected in got.items():
        scale = np.max(np.abs(expected - expected[0]))
        assert np.max(np.abs(result[signal].values - expected)) < 1e-9 * scale, signal


def test_the_composition_in_space_is_the_independent_loop_to_1e_9(
    tmp_path: Path,
) -> None:
    loaded = load_scenario("contouring_lpv/lqg_space", [f"stop={STOP}"])
    result = session.run(loaded, tmp_path, report=False)
    content = json.loads((FOLDER / "lqg_spatial.json").read_text())
    positions, commands = run_in_space(content, 0.25e-3, STOP)
    for i, name in enumerate("xyz"):
        u_c = result[f"plant.u_c{name}"].values - positions[::4, i]
        v_m = result[f"controller.v_m{name}"].values - commands[:, i]
        assert np.max(np.abs(u_c)) < 1e-9 * np.max(np.abs(positions)), name
        assert np.max(np.abs(v_m)) < 1e-9 * np.max(np.abs(commands)), name
