"""Yield and borders of a sweep are those that ``run`` finds, point by point."""

from itertools import pairwise
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.tolerances import tolerances_of
from orchestrator.analysis.variations import Axis, sample
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

MEMBERS, POINTS = 33, 10
STUDIES = {  # what is varied, and what must hold within some of it
    "ball_screw_pole_placement/mc_ppc_track_500": (
        ("plant.m_2", "plant.k"),
        {"tracking.peak": (3.0, "um"), "u.peak": (7.2, "V")},
    ),
    "gantry/mimo_line_200": (
        ("y_plant.m", "y_plant.J_0"),
        {"tracking.peak": (2.0, "um")},
    ),
    "leadscrew_nctf/step": (
        ("x_axis.M", "x_axis.T_c"),
        {"x_residual.span": (0.48, "nm"), "x.overshoot": (0.027, "%")},
    ),
}


def written(study: str, folder: Path) -> Path:
    varied, limits = STUDIES[study]
    base = load_scenario(study).file
    place = folder / "study"
    copytree(base.parent, place)  # its designs name scenarios beside it
    lines = [f'base = "{base.name}"', "[expect]"]
    for figure, (most, unit) in limits.items():
        lines.append(f'"{figure}" = {{ below = {most}, unit = "{unit}" }}')
    lines += ["[tolerances]", *(f'"{key}" = "+-20 %"' for key in varied)]
    file = place / "varied.toml"
    file.write_text("\n".join(lines))
    return file


@pytest.mark.parametrize("study", STUDIES)
def test_yield_and_borders_are_those_of_single_runs(
    study: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Ten points beside the borders, ten of a sample: only with --every-form."""
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form confirms sweeps of three studies")
    file = written(study, tmp_path)
    composition = compose(load_scenario(file), run_earlier)
    key = STUDIES[study][0][0]
    nominal = composition.parameter(key).value
    values = (nominal * np.linspace(0.7, 1.3, MEMBERS)).tolist()
    borders = sweep(file, [Axis(key, tuple(values))])
    yields = sweep(file, sample(tolerances_of(composition), "sobol", 64, seed=1))
    assert borders.executors == yields.executors == ("lanes",)
    met = [row["met"] for row in borders.rows]
    at = [i + 0.5 for i, (a, b) in enumerate(pairwise(met)) if a != b]
    assert at, "the range must hold a border"
    assert 0 < yields.met < 1
    near = sorted(range(MEMBERS), key=lambda i: min(abs(i - place) for place in at))
    some = np.random.default_rng(5).choice(64, POINTS, replace=False)
    points = [borders.rows[i] for i in near[:POINTS]] + [yields.rows[i] for i in some]
    for n, row in enumerate(points):
        sets = [f"{k}={row[k]!r}" for k in STUDIES[study][0] if k in row]
        alone = run(load_scenario(file, sets), tmp_path / str(n))
        assert row["met"] == all(check.met for check in alone.checks)
        for name, figure in alone.metrics.items():
            assert row[name] == figure.value
    print(f"{study}: borders at {[values[int(i)] for i in at]}, yield {yields.met:.2f}")
