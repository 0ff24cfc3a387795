"""What the gantry study must show, from its own scenarios."""

from pathlib import Path

import numpy as np
import pytest
from simulated import Co

from controllers.synthesis.gantry import identification as gantry_identification
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

STUDY = "gantry"


@pytest.mark.parametrize(
    "only",
    [
        "plant.*",
        "x.*",
        "mimo.[csty]*",
        "mimo.no_damping.*",
        "pid.[csy]*",
        "*.line_200.*",
        "*.line_200_no_feedforward.*",
        "*.rope_snap.peak*",
        "identification.*",
    ],
)
def test_figures_are_within_the_tolerances_of_the_study(
    only: str, tmp_path: Path
) -> None:
    figures = reproduce("gantry", only, processes=1, folder=tmp_path).figures
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    assert any(f.spec.expected is not None for f in figures)


def test_the_table_after_the_snap_is_where_an_independent_computation_has_it(
    co_simulated: Co,
) -> None:
    y_t = co_simulated("mimo_rope_snap")["y_plant.y_t"]
    at = np.array([2, 5, 10, 20, 50]) * 15
    expected = np.array([0.7641, 3.6316, 6.2387, 2.9685, 0.1826]) * 1e-6
    assert y_t.values[at] == pytest.approx(expected, rel=0.01)


def test_a_sample_of_delay_is_what_makes_the_errors(co_simulated: Co) -> None:
    late = [f"{axis}_controller.latency=0" for axis in "xy"]
    for scenario, peak in (
        ("mimo_line_200", 0.0253),
        ("x_line_200", 0.209),
        ("pid_line_200", 0.310),
    ):
        found = co_simulated(scenario, *late).metrics["tracking.peak"]
        assert found.to("um").value == pytest.approx(peak, rel=0.02), scenario


def test_prefilters_take_out_most_of_the_error(co_simulated: Co) -> None:
    for scenario, peak in (("mimo", 0.0451), ("pid", 0.607), ("x", 0.101)):
        found = co_simulated(f"{scenario}_line_200_prefilter").metrics["tracking.peak"]
        assert found.to("um").value == pytest.approx(peak, rel=0.05), scenario


def test_noisy_responses_of_the_running_fmus_give_the_gantry_back(
    co_simulated: Co,
) -> None:
    record = co_simulated("identification")
    names = ("y_controller.u_1", "y_controller.u_2", "encoder.y_1m", "encoder.y_2m")
    u_1, u_2, y_1, y_2 = (record[name].values for name in names)
    T_s = 1 / 15_000
    clean = gantry_identification.yaw(T_s, u_1, u_2, y_1, y_2)
    assert clean["J_0"] == pytest.approx(0.4342, rel=1e-4)
    assert clean["c"] == pytest.approx(18.17, rel=1e-4)
    assert clean["k"] == pytest.approx(159_200, rel=1e-4)
    rng = np.random.default_rng(0)
    # a hundred times the encoders' quantisation noise, white
    noise = rng.standard_normal((2, len(y_1))) * 0.3e-6
    noisy = gantry_identification.yaw(T_s, u_1, u_2, y_1 + noise[0], y_2 + noise[1])
    assert noisy["J_0"] == pytest.approx(0.4342, rel=0.01)
    assert noisy["c"] == pytest.approx(18.17, rel=0.05)
    assert noisy["k"] == pytest.approx(159_200, rel=0.01)


def test_a_record_that_ends_too_early_is_refused() -> None:
    signals = np.zeros((4, 30_000))
    with pytest.raises(ValueError, match="record ends before 3 s"):
        gantry_identification.yaw(1 / 15_000, *signals)


def test_a_wrong_estimate_without_damping_grows_as_the_eigenvalues_say(
    co_simulated: Co,
) -> None:
    theta = co_simulated("mimo_line_200_no_damping")["y_plant.theta"]
    period = 1 / 94.13
    rows = [(theta.time > t) & (theta.time < t + 4 * period) for t in (0.5, 0.7)]
    early, late = (np.sqrt(np.mean(theta.values[r] ** 2)) for r in rows)
    assert late / early == pytest.approx(np.exp(0.2 / 0.0717), rel=0.05)


def test_the_schedule_makes_the_table_position_invisible(co_simulated: Co) -> None:
    middle = co_simulated("mimo_line_200").metrics["tracking.peak"].value
    for place in ("minus", "plus"):
        there = co_simulated(f"mimo_line_200_at_{place}_150").metrics
        frozen = co_simulated(f"mimo_line_200_at_{place}_150_unscheduled").metrics
        assert there["tracking.peak"].value == pytest.approx(middle, rel=1e-6)
        assert frozen["tracking_2.peak"].value > 5 * middle


def test_the_report_draws_the_contour_with_its_error_magnified(tmp_path: Path) -> None:
    scenario = load_scenario("gantry/circle_200", ["stop=1/2"])
    # half a second, so that the window of the whole turn is not asked for
    metric = scenario.spec.metrics["contour"].model_copy(update={"window": None})
    kept = {"contour": metric}
    spec = scenario.spec.model_copy(update={"metrics": kept})
    short = type(scenario)(scenario.name, scenario.file, spec, scenario.nominal)
    done = run(short, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Contours" in page
    assert "error magnified" in page
    assert done.metrics["contour.peak"].to("um").value < 0.02
