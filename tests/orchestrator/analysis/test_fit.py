"""Fits to co-simulated records: they find what was simulated, as surely as they say."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.analysis.estimate import estimate
from orchestrator.analysis.fit import assigned, fit, free_values
from orchestrator.analysis.measured import beside
from orchestrator.cli import app
from orchestrator.errors import FeedDriveError, FitError
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier
from orchestrator.supplied import build_supplied

RATE, ROWS = 2000, 801
NOISE = {"x_1": 1e-4, "x_2": 2e-4}
TRUE = {"m_1": 1.858e-3, "m_2": 0.379e-3, "b_1": 1.02e-3, "k": 210.02}
FREE = [f"plant.{name}" for name in TRUE]
OURS = """\
stop = "1"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/4000"
parameters = { m_1 = 1.9e-3, m_2 = 0.37e-3, b_1 = 1.0e-3, k = 207 }
[components.idle]
fmu = "controllers.references.trajectory"
[connections]
"plant.u" = "idle.x_r"
"""
THEIRS = """\
stop = "1"
[components.plant]
fmu = "ball_screw.fmu"
step = "1/2000"
parameters = {{ {values} }}
"""


@cache
def voltages() -> np.ndarray:
    bits = np.random.default_rng(8).choice([-2.0, 2.0], size=ROWS // 8 + 1)
    return np.repeat(bits, 8)[:ROWS]


def written(file: Path, **columns: np.ndarray) -> Path:
    head = ",".join(["t [s]", *(name.replace("__", ".") for name in columns)])
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join([repr(k / RATE), *map(repr, row)]) for k, row in enumerate(rows)]
    file.write_text("\n".join([head, *lines]) + "\n")
    return file


def composed(folder: Path, text: str = OURS) -> Composition:
    (folder / "axis.toml").write_text(text)
    return compose(load_scenario(folder / "axis.toml"), run_earlier)


def record(
    composition: Composition, folder: Path, true: dict[str, float], *outputs: str
) -> tuple[Path, dict[str, np.ndarray]]:
    """Return a file to be filled in and what the plant gives with the true values."""
    nothing = np.zeros(ROWS)
    file = written(
        folder / "m.csv",
        **{INPUT[len(outputs)]: voltages(), **dict.fromkeys(outputs, nothing)},
    )
    measured = beside(composition, file)
    with measured.series() as series:
        values = assigned([*true], [*true.values()])
        return file, measured.run(series, values)


INPUT = {2: "plant__u [V]", 1: "plant__motor_voltage [V]"}


def test_intervals_cover_the_true_values_as_often_as_they_say(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Two masses, damping and stiffness; noise of another size on either signal."""
    seeds = 200 if request.config.getoption("--every-form") else 8
    composition = composed(tmp_path)
    true = dict(zip(FREE, TRUE.values(), strict=True))
    outputs = [f"plant__{n} [rad]" for n in NOISE]
    file, clean = record(composition, tmp_path, true, *outputs)
    free = free_values(composition, FREE, {})
    measured = beside(composition, file)
    assert set(measured.system.components) == {"plant", "measured"}  # idle is not run
    covered, scaled = np.zeros(len(FREE)), []
    for seed in range(seeds):
        random = np.random.default_rng(1000 + seed)
        noisy = {
            name: y + random.normal(size=ROWS) * NOISE[name.removeprefix("plant.")]
            for name, y in clean.items()
        }
        told = type(measured)(measured.system, measured.period, measured.driven, noisy)
        found = fit(composition, told, free, unused=0.0).found
        x = np.array([*TRUE.values()])
        covered += (found.intervals[:, 0] <= x) & (x <= found.intervals[:, 1])
        scaled.append(
            (found.values - x) @ np.linalg.solve(found.covariance, found.values - x)
        )
    print(f"{seeds} seeds: covered {dict(zip(TRUE, covered / seeds, strict=True))}")
    from scipy.stats import chi2

    low, high = chi2.ppf([1e-4, 1 - 1e-4], seeds * len(FREE))
    assert low < sum(scaled) < high  # the covariance is that of the errors made
    if seeds == 200:
        assert np.all((covered >= 0.90 * seeds) & (covered <= 0.99 * seeds))


def test_a_plant_that_nobody_here_wrote_is_fitted_in_its_own_units(
    tmp_path: Path,
) -> None:
    """Foreign names, mm and mVs2/rad; the rows not used are met as the others."""
    build_supplied("supplied.ball_screw", tmp_path)
    true = {"plant.inertia_motor": 1.7, "plant.bearing": 1.15}
    composition = composed(tmp_path, THEIRS.format(values=""))
    file, clean = record(composition, tmp_path, true, "plant__table [mm]")
    (table,) = clean.values()
    random = np.random.default_rng(2)
    noisy = table + 1e-3 * random.normal(size=ROWS)
    columns: dict[str, Any] = {INPUT[1]: voltages(), "plant__table [mm]": noisy}
    written(file, **columns)
    line = ["fit", str(tmp_path / "axis.toml"), "--data", str(file), "--free"]
    line += [",".join(true), "-o", str(tmp_path / "found.toml"), "--json"]
    done = CliRunner().invoke(app, line)
    told = json.loads(done.stdout)
    assert set(told) == {"values", "residual_rms", "scenario"}
    assert told["residual_rms"] == pytest.approx(1e-3, rel=0.1)
    for name, x in true.items():
        found = told["values"][name]
        assert abs(found["value"] - x) < 5 * found["standard_error"] < 0.05 * x
    assert told["values"]["plant.bearing"]["unit"] == "mVs/rad"
    again = compose(load_scenario(told["scenario"]), run_earlier)
    for name, found in told["values"].items():
        assert again.parameter(name).value == found["value"]


def test_the_covariance_is_that_of_a_straight_line(tmp_path: Path) -> None:
    """Ordinary least squares by hand, where it can be done by hand."""
    t = np.linspace(0, 1, 50)
    y = 2 + 3 * t + 0.1 * np.random.default_rng(1).normal(size=50)
    wide = np.array([[-10.0, 10.0]] * 2)
    found = estimate(
        lambda x: x[0] + x[1] * t - y, np.array([1.0, 1.0]), wide, ("a", "b")
    )
    design = np.stack([np.ones(50), t], axis=1)
    best, rest, *_ = np.linalg.lstsq(design, y)
    np.testing.assert_allclose(found.values, best, rtol=1e-6)
    covariance = rest[0] / 48 * np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-5)
    with pytest.raises(FitError, match="a combination of a, b"):
        estimate(lambda x: x[0] + x[1] - y, np.array([1.0, 1.0]), wide, ("a", "b"))
    with pytest.raises(FitError, match="do not tell b: nothing"):
        estimate(lambda x: x[0] + 0 * t - y, np.array([1.0, 1.0]), wide, ("a", "b"))


@pytest.mark.parametrize(
    ("columns", "free", "bounds", "said"),
    [
        ({"plant__u [V]": 0}, "plant.m_1", {}, "nothing is to be compared"),
        ({"plant__x_3 [rad]": 0}, "plant.m_1", {}, "has no variable 'x_3'"),
        ({"plant__x_1 [N]": 0}, "plant.m_1", {}, "plant.x_1"),
        ({"x_1 [rad]": 0}, "plant.m_1", {}, "is no component.variable"),
        ({"plant__x_1 [rad]": 0}, "plant.step", {}, "no real parameter"),
        ({"plant__x_1 [rad]": 0}, "plant.b_2", {}, "--bounds plant.b_2=LOW:HIGH"),
        ({"plant__x_1 [rad]": 0}, "plant.k", {"plant.k": (1, 2)}, "does not hold"),
    ],
)
def test_what_makes_no_fit_is_refused_in_words(
    columns: dict[str, int], free: str, bounds: Any, said: str, tmp_path: Path
) -> None:
    composition = composed(tmp_path)
    file = written(tmp_path / "m.csv", **{n: np.zeros(ROWS) for n in columns})
    with pytest.raises(FeedDriveError) as refused:
        fit(
            composition,
            beside(composition, file),
            free_values(composition, [free], bounds),
        )
    assert said in str(refused.value)
