"""What a scenario sets without effect is said, and nothing else is."""

import pytest

from orchestrator.errors import DesignError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import STUDIES, load_scenario
from orchestrator.session import run_earlier

TRACK = "ball_screw_pole_placement/mc_ppc_track_500"


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("plant.u=3", "plant.u is set, but controller.u drives it"),
        ("plant.start.u=3", "only where the initialisation begins"),
        ("controller.latency=15013", "published before the run ends at 0.7506 s"),
    ],
)
def test_a_value_without_effect_is_said_with_its_reason(caplog, override, said):
    compose(load_scenario(TRACK, [override]), run_earlier)
    assert said in caplog.text


@pytest.mark.parametrize("override", ["plant.d_2=3", "controller.latency=15012"])
def test_a_value_with_an_effect_is_let_pass(caplog, override):
    compose(load_scenario(TRACK, [override]), run_earlier)
    assert caplog.text == ""


@pytest.mark.parametrize("study", ["gantry/circle_200", "cascade_nppi/p_pi_circle"])
def test_the_studies_set_nothing_in_vain(caplog, study):
    compose(load_scenario(STUDIES / f"{study}.toml"), run_earlier)
    assert caplog.text == ""


def test_a_design_for_a_component_that_was_swapped_can_be_left_out():
    swap = {"controller": {"fmu": "controllers.ball_screw.p_pi"}}
    with pytest.raises(DesignError, match=r"no such parameter.*design.gains=false"):
        compose(load_scenario(TRACK, swaps=swap), run_earlier)
    left_out = load_scenario(TRACK, ["design.gains=false"], swap)
    assert compose(left_out, run_earlier).designs == {}
