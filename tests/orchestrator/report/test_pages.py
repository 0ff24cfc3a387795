"""What a report says of errors and control signals, and how results show themselves."""

import re
from fractions import Fraction
from hashlib import sha256
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.analysis.sweep import Sweep
from orchestrator.evaluation.spectrum import amplitudes
from orchestrator.report import analysed
from orchestrator.report.notebook import write_scenario
from orchestrator.report.page import write_report
from orchestrator.report.shell import LINES
from orchestrator.response.measured import Response
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run
from orchestrator.shown import framed

PLOTLY_BASIC_4_1_1 = "99784e3abfb07b142a15e521a439e6d9addceadb3f79553fd24c72774f0649ba"
TRACK = "ball_screw_pole_placement/mc_ppc_track_500"


@pytest.fixture(scope="module")
def track(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    folder = tmp_path_factory.mktemp("track")
    sets = ["stop=0.1", 'metrics.tracking.window=["0.02", "0.08"]']
    done = run(load_scenario(TRACK, sets), folder / "run")
    return SimpleNamespace(run=done, page=(folder / "run/report.html").read_text())


def test_the_strongest_line_has_the_amplitude_of_the_sine_and_its_frequency() -> None:
    time = np.arange(4000) / 4000
    hertz, size = amplitudes(time, 3 * np.sin(2 * np.pi * 50 * time))
    k = int(np.argmax(size))
    assert hertz[k] == pytest.approx(50)
    assert size[k] == pytest.approx(3, rel=1e-2)


def test_an_error_is_analysed_within_its_window(track: SimpleNamespace) -> None:
    ((name, series),) = analysed._errors(track.run, 0)
    assert name.startswith("tracking")
    assert (series.time[0], series.time[-1]) == (0.02, 0.08)
    assert np.max(np.abs(series.values)) == track.run.metrics["tracking.peak"].value
    v_r = np.gradient(track.run["trajectory.x_r"].values[400:1601], 5e-5)
    per_rad = 3.183098861837907  # mm, the pitch of 20 mm a turn
    assert np.max(series.velocity) == pytest.approx(per_rad * np.max(v_r), rel=1e-3)
    spectrum, density, *_, worst = analysed._curves(series)
    assert len(spectrum[0]) == len(series.time) // 2
    assert np.sum(density[1]) == pytest.approx(100)
    assert np.max(np.abs(worst[1])) == np.max(np.abs(series.values))


def test_a_report_has_wiring_times_units_and_what_the_error_is_made_of(
    track: SimpleNamespace,
) -> None:
    page = track.page
    for said in (
        "<h2>Wiring</h2>",
        "<h2>Timetable</h2>",
        "tracking: what the error is made of",
        "controller.u: what the control signal is made of",
        "age when taken (us)",
    ):
        assert said in page
    row = r"<td>plant\.u</td><td>controller\.u</td><td>V</td><td>50</td>"
    assert re.search(row, page)
    assert page.count("<!doctype html>") == 1
    own = page.replace(LINES.read_text(), "")
    assert not re.search(r"""(src|href)=["']""", own)


def test_the_library_is_the_file_that_was_published() -> None:
    assert sha256(LINES.read_bytes()).hexdigest() == PLOTLY_BASIC_4_1_1


def test_two_runs_of_one_wiring_show_it_once(track: SimpleNamespace, tmp_path) -> None:
    page = write_report([track.run, track.run], tmp_path / "x.html").read_text()
    assert page.count("<title>Wiring of trajectory, controller, plant, encoder<") == 1
    assert page.count("<title>Timetable of") == 1


def test_a_scenario_shows_its_pictures_or_why_there_are_none(tmp_path) -> None:
    page = write_scenario(load_scenario(TRACK), tmp_path / "x.html").read_text()
    assert "Timetable of" in page
    assert len(page) < 50_000  # without Plotly
    scenario = load_scenario(TRACK, ["connections.plant.u=encoder.nothing"])
    assert (
        "encoder.nothing" in write_scenario(scenario, tmp_path / "y.html").read_text()
    )


def test_what_a_notebook_shows_is_framed_and_nothing_leaves_the_frame(
    track: SimpleNamespace,
) -> None:
    shown = track.run._repr_html_()
    assert shown.startswith('<iframe title="feeddrive" srcdoc="&lt;!doctype html&gt;')
    assert shown.count('"') == 2 * len(re.findall(r' \w+="', shown))
    assert "tracking.peak" in unescape(shown)
    assert "&lt;script" in framed(lambda file: file.write_text("<script>"))


def test_a_sweep_and_a_response_show_their_pages() -> None:
    rows = [
        {"member": i, "plant.m": float(i), "x.peak": 2.0, "met": True, "broken": []}
        | {"failure": None}
        for i in range(3)
    ]
    found = Sweep("drive", ("plant.m",), tuple(rows), {"x.peak": "um"}, 1.0, ())
    assert "3 members, yield 100 %" in unescape(found._repr_html_())
    hz = np.logspace(0, 3, 50)
    L = (100 / (2j * np.pi * hz))[:, None, None]
    nothing = {"coherence": np.ones((50, 1)), "amplitude": (0.1,), "distortion": 0.0}
    nothing |= {"alias": 0.0, "half": 0.0, "settled": 1, "realisations": 1}
    nothing |= {"error": 0.0, "period": Fraction(1), "sample": Fraction(1, 1000)}
    nothing |= {"slower": None, "range": np.zeros((1, 2)), "measured": (1.0, 2.0)}
    loop = {"hz": hz, "L": L, "S": 1 / (1 + L), "T": L / (1 + L)}
    response = Response(breaks=("controller.u",), units=("V",), **loop, **nothing)
    shown = unescape(response._repr_html_())
    assert shown.count('class="plotly-graph-div"') == 3
    assert "<h1>controller.u</h1>" in shown
