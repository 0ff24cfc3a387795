"""A report shows every peak and what produced it."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.errors import ScenarioError
from orchestrator.report.figure import decimate
from orchestrator.report.page import write_report
from orchestrator.report.panels import names_of, panels
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run


@given(st.integers(1, 30_000), st.integers(0, 2**32 - 1))
def test_thinning_keeps_ends_extremes_and_order(n, seed):
    values = np.random.default_rng(seed).normal(size=n)
    time = np.arange(n) / 20_000
    thin_time, thin = decimate(time, values)
    assert len(thin) <= 5000
    assert (thin[0], thin[-1]) == (values[0], values[-1])
    assert (thin.min(), thin.max()) == (values.min(), values.max())
    assert np.all(np.diff(thin_time) > 0)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    found = []
    for v_max in ("0.4", "0.5"):
        settings = ["stop=0.05", f"trajectory.v_max={v_max}"]
        scenario = load_scenario("ball_screw_pole_placement/mc_ppc_track_500", settings)
        found.append(run(scenario, folder / v_max, report=False))
    return found


def test_one_run_shows_reference_actual_error_and_control_signal(runs):
    titles = [panel.title for panel in panels(runs[:1])]
    assert titles[:2] == ["tracking: reference and actual", "tracking: error"]
    assert "control signal" in titles


def test_compared_runs_share_panels_and_say_whose_curve_is_whose(runs):
    alone, both = list(panels(runs[:1])), list(panels(runs))
    assert [p.title for p in alone] == [p.title for p in both]
    for panel in both:
        assert {curve.run for curve in panel.curves} == {0, 1}


def test_names_of_compared_runs_lose_what_they_share():
    def run(title):
        spec = SimpleNamespace(title=title)
        return SimpleNamespace(scenario=SimpleNamespace(spec=spec))

    cascade, placed = run("P-PI, set A, at 500 mm/s"), run("MC-PPC at 500 mm/s")
    assert names_of([cascade, placed]) == ["P-PI, set A", "MC-PPC"]
    assert names_of([placed, placed]) == ["MC-PPC at 500 mm/s"] * 2
    assert names_of([placed]) == ["MC-PPC at 500 mm/s"]
    assert names_of([run("one"), run("two")]) == ["one", "two"]


def test_a_report_is_one_file_that_names_components_rates_and_digests(runs, tmp_path):
    page = write_report(runs, tmp_path / "report.html", "A < B").read_text()
    assert "<h1>A &lt; B</h1>" in page
    assert "20 kHz" in page
    assert runs[0].composition.digests["plant"][:12] in page
    assert "<script src=" not in page


def test_a_report_of_nothing_is_refused(tmp_path):
    with pytest.raises(ScenarioError, match="at least one run"):
        write_report([], tmp_path / "report.html")
