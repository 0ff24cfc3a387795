"""Tuned gains keep what they are subject to, and no independent search is better."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.analysis import tune as tuning
from orchestrator.analysis.begin import free_of
from orchestrator.analysis.candidates import Constraint, parse_constraint
from orchestrator.analysis.fit import Free
from orchestrator.analysis.heir import words, write_heir
from orchestrator.analysis.shots import Shots
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.tune import Space, tune
from orchestrator.analysis.variations import Axis
from orchestrator.cli import app
from orchestrator.errors import FitError, TuneError
from orchestrator.response.expected import loop, respond
from orchestrator.response.figures import figures
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

SCENARIO = """
base = "cascade_nppi/p_pi_0_4hz"
stop = "1/2"
metrics.tracking.window = ["1/4", "1/2"]

[responses]
loop = { break = "controller.u", from = "4 Hz" }
way = { excite = "plant.d", observe = "plant.y" }
"""
BOUND = "loop.modulus_margin >= 0.4"


def composed(file: Path, values: Mapping[str, Any] | None = None) -> Composition:
    sets = [f"{name}={value!r}" for name, value in (values or {}).items()]
    return compose(load_scenario(file, sets), run_earlier)


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "table.toml"
    file.write_text(SCENARIO)
    return file


def test_tuned_gains_keep_their_margin_in_the_worst_variation(
    scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is found is run, measured and swept once more by other means."""
    monkeypatch.chdir(scenario.parent)
    asked = ["--free", "controller.k_v,controller.k_p", "--minimise", "tracking.peak"]
    asked += ["--subject-to", BOUND, "--over", "plant.b=+-10%", "--generations", "4"]
    done = CliRunner().invoke(app, ["tune", str(scenario), *asked, "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    heir = Path(told["scenario"])
    assert told["best"].keys() == {"controller.k_v", "controller.k_p"}
    composition = composed(heir)
    found = loop(composition, composition.scenario.spec.responses["loop"])
    assert figures("loop", found)["loop.modulus_margin"].value >= 0.4
    values = tuple(np.linspace(0.9, 1.1, 3) * 78020.0)
    rows = sweep(heir, [Axis("plant.b", values)]).rows
    peaks = [row["tracking.peak"] for row in rows]
    assert max(peaks) == pytest.approx(told["objective"], rel=1e-9)
    assert told["worst_case"]["plant.b"] == pytest.approx(values[np.argmax(peaks)])
    assert told["before"] > 0
    page = heir.with_suffix(".html").read_text()
    assert "before controller.u" in page
    assert "tuned controller.u" in page


CASCADE = """
base = "cascade_nppi/np_pi_split_0_7hz"
stop = "1/4"
METRICS
[components.position.parameters]
KO = 0
[responses]
both = { break = ["position.v_ref", "velocity.u"], from = "8 Hz" }
inner = { break = "velocity.u", from = "8 Hz" }
[tune.start]
call = "controllers.synthesis.xy_table.recipes:p_pi"
arguments = { b = "plant.b", tau = "plant.tau", phase_margin_deg = 60 }
sets = "velocity"
"""


def test_bounds_are_kept_at_several_breaks_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A matrix of two breaks, one of them by itself, and a recipe to begin with."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "cascade.toml"
    file.write_text(
        CASCADE.replace("METRICS", "").replace('sets = "velocity"', 'sets = "position"')
    )
    refused = CliRunner().invoke(
        app, ["tune", str(file), "--free", "velocity.k_p", "--minimise", "e.peak"]
    )
    assert "tune.start: k_p is no real parameter of position" in refused.output
    file.write_text(CASCADE.replace(":p_pi", ":speed_pi").replace("METRICS", ""))
    asked = ["--free", "velocity.k_p", "--minimise", "e.peak", "--generations", "1"]
    refused = CliRunner().invoke(app, ["tune", str(file), *asked])
    assert "a run failed: metrics.tracking: no row of plant.y" in refused.output
    shorter = CASCADE.replace("METRICS", "metrics.tracking = false")
    file.write_text(shorter.replace(":p_pi", ":speed_pi"))
    composition = composed(file)
    full = loop(composition, composition.scenario.spec.responses["both"])
    shots = Shots(composition, full)
    (shot,) = shots.take([{}])
    shots.close()
    wanted = figures("both", full)
    for name in ("modulus_margin", "phase_margin_deg", "gain_margin_db", "s_max"):
        assert shot.figure(name) == pytest.approx(
            wanted[f"both.{name}"].value, rel=0.05
        )
    asked = ["--free", "velocity.k_p,velocity.k_i", "--minimise", "e.peak"]
    asked += ["--subject-to", "both.phase_margin_deg >= 20", "--generations", "1"]
    asked += ["--subject-to", "inner.modulus_margin >= 0.33", "--json"]
    done = CliRunner().invoke(app, ["tune", str(file), *asked])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["start"].keys() == {"velocity.k_p", "velocity.k_i"}
    found = respond(composed(Path(told["scenario"]))).figures
    assert found["both.phase_margin_deg"].value >= 20
    assert found["inner.modulus_margin"].value >= 0.33


def test_a_published_scenario_is_inherited_from_by_its_name(tmp_path: Path) -> None:
    published = compose(load_scenario("cascade_nppi/p_pi_0_4hz"), run_earlier)
    heir = write_heir(
        published, {"controller.k_v": 200.0}, "slower", tmp_path / "h.toml"
    )
    assert 'base = "cascade_nppi/p_pi_0_4hz"' in heir.read_text()
    done = run(heir, tmp_path / "run", report=False)
    assert done.composition.parameter("controller.k_v").value == 200.0


def test_no_values_that_keep_the_bounds_are_told_as_such(scenario: Path) -> None:
    composition = composed(scenario)
    free = free_of(composition, ["controller.k_v"], {"controller.k_v": (200.0, 250.0)})
    with pytest.raises(TuneError, match="no candidate keeps loop"):
        tune(
            composition,
            free,
            "tracking.peak",
            [Constraint("loop.modulus_margin", 1, 0.95)],
            generations=1,
            recompose=lambda values: composed(scenario, values),
        )


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("loop.s_max <= 2", Constraint("loop.s_max", -1, 2.0)),
        ("tracking.peak>=1e-3", Constraint("tracking.peak", 1, 1e-3)),
    ],
)
def test_bounds_are_read(text: str, found: Constraint) -> None:
    assert parse_constraint(text) == found


def test_a_bound_written_otherwise_is_refused() -> None:
    with pytest.raises(TuneError, match="write "):
        parse_constraint("loop.s_max < two")


def test_what_is_missed_is_measured_in_shares_of_the_bound() -> None:
    above = Constraint("loop.modulus_margin", 1, 0.5)
    assert above.missed(0.6) == 0
    assert above.missed(0.4) == pytest.approx(0.2)
    assert Constraint("loop.s_max", -1, 2.0).missed(3.0) == pytest.approx(0.5)


def test_free_names_may_be_patterns(scenario: Path) -> None:
    names = [f.name for f in free_of(composed(scenario), ["controller.k_*"], {})]
    assert names == ["controller.k_v", "controller.k_p", "controller.k_i"]
    with pytest.raises(TuneError, match="matches no real parameter"):
        free_of(composed(scenario), ["controller.q_*"], {})
    with pytest.raises(FitError, match="not among"):
        free_of(composed(scenario), ["controller.k_v"], {"controller.k_p": (1, 2)})


def test_unknown_figures_are_refused(scenario: Path) -> None:
    composition = composed(scenario)
    free = free_of(composition, ["controller.k_v"], {})
    for objective, bound, complaint in (
        ("trackin.peak", None, "no such metric"),
        ("tracking.peak", Constraint("loop.s_mx", -1, 2.0), "no such figure"),
        ("tracking.peak", Constraint("lop.s_max", -1, 2.0), "neither"),
        ("tracking.peak", Constraint("way.peak", -1, 2.0), "breaks no loop"),
    ):
        with pytest.raises(TuneError, match=complaint):
            tune(
                composition,
                free,
                objective,
                [bound] if bound else [],
                recompose=lambda values: composition,
            )


SNAP = """
base = "ball_screw_pole_placement/p_pi_a_rope_snap"
stop = "1/10"
[metrics]
u = { kind = "rms", of = "controller.u" }
[record]
"controller.u" = "control"
"""


@pytest.fixture
def snap(tmp_path: Path) -> Path:
    file = tmp_path / "snap.toml"
    file.write_text(SNAP)
    return file


def tuned(file: Path, objective: str, *constraints: Constraint, **more: Any) -> Any:
    composition = composed(file)
    return tune(
        composition,
        free_of(composition, ["controller.K_px"], {"controller.K_px": (1.0, 200.0)}),
        objective,
        constraints,
        generations=0,
        recompose=lambda values: composed(file, values),
        **more,
    )


def test_a_figure_without_a_value_keeps_no_bound(snap: Path) -> None:
    assert Constraint("x.settling", -1, 0.05).missed(float("nan")) > 0
    assert Constraint("x.settling", 1, 0.05).missed(float("nan")) > 0
    snap.write_text(SNAP.replace("1/10", "1/100"))  # it does not settle so soon
    with pytest.raises(TuneError, match=r"snap\.settling has no value"):
        tuned(snap, "u.rms", Constraint("snap.settling", -1, 0.05))


def test_a_misspelled_figure_of_a_metric_is_refused_not_left_out(snap: Path) -> None:
    with pytest.raises(TuneError, match=r"--subject-to snap\.peek: .*snap\.peak"):
        tuned(snap, "u.rms", Constraint("snap.peek", -1, 1.0))
    with pytest.raises(TuneError, match=r"--minimise u\.rmss: .*u\.rms"):
        tuned(snap, "u.rmss")


def test_what_misses_its_bound_at_the_last_measurement_is_refused(
    scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The quick looks keep it, the full measurement never does."""
    composition = composed(scenario)
    response = composition.scenario.spec.responses["loop"]
    worse = loop(composed(scenario, {"controller.k_v": 400.0}), response)
    bound = figures("loop", worse)["loop.modulus_margin"].value + 0.02
    monkeypatch.setattr(tuning, "_measured", lambda *_: [{"loop": worse}])
    monkeypatch.setattr(tuning, "ROUNDS", 1)
    bounds = {"controller.k_v": (150.0, 250.0)}
    with pytest.raises(TuneError, match="when measured in full"):
        tune(
            composition,
            free_of(composition, ["controller.k_v"], bounds),
            "tracking.peak",
            [Constraint("loop.modulus_margin", 1, bound)],
            generations=0,
            recompose=lambda values: composed(scenario, values),
        )


DESIGNED = """
base = "ball_screw_pole_placement/mc_ppc_track_500"
stop = "1/20"
"""


def test_the_scenario_written_has_the_objective_printed_where_a_design_reads_a_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a file the value found would be what the design is told."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "d.toml"
    file.write_text(DESIGNED)
    asked = ["--free", "plant.m_2", "--bounds", "plant.m_2=3e-4:6e-4"]
    asked += ["--minimise", "tracking.peak", "--generations", "0"]
    done = CliRunner().invoke(app, ["tune", str(file), *asked, "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    alone = run(load_scenario(told["scenario"]), tmp_path / "run", report=False)
    assert alone.metrics["tracking.peak"].value == told["objective"]
    nominal = composed(file).parameter("plant.m_2").value
    assert told["best"]["plant.m_2"] != nominal
    assert alone.composition.designs["gains"].arguments["m_2"] == nominal


def test_a_design_that_is_not_kept_is_told_what_was_found(tmp_path: Path) -> None:
    (tmp_path / "d.toml").write_text(DESIGNED)
    composition, values = composed(tmp_path / "d.toml"), {"plant.m_2": 4e-4}
    anew = write_heir(composition, values, "fitted", tmp_path / "h.toml", kept=())
    assert composed(anew).designs["gains"].arguments["m_2"] == 4e-4
    assert "m_2 as found" in words(composition, values, kept=())[0]
    assert "m_2 as before" in words(composition, values)[0]


def test_what_is_free_is_not_varied_too(snap: Path) -> None:
    with pytest.raises(TuneError, match=r"--over controller\.K_px: is free too"):
        tuned(snap, "u.rms", over=[Axis("controller.K_px", (100.0, 200.0))])


def test_brackets_are_searched_in_ratios_where_they_are_positive() -> None:
    space = Space([Free("a", 1.0, (0.1, 10.0), "1"), Free("b", 0.0, (-1.0, 1.0), "1")])
    assert space.values(np.array([0.5, 0.5])) == pytest.approx([1.0, 0.0])
    assert space.places(np.array([1.0, 0.5])) == pytest.approx([0.5, 0.75])
