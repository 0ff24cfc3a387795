"""Names of the first edition: each is refused with the one that took its place."""

from importlib.util import find_spec

import pytest
from modules import MODULES

from orchestrator.errors import DesignError, ScenarioError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.design import find_function
from orchestrator.scenario.moved import MOVED
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier


def test_an_old_name_is_refused_with_the_new_one(tmp_path):
    file = tmp_path / "old.toml"
    file.write_text(
        'stop = "1"\n[components.c]\nfmu = "controllers.mc_ppc"\nstep = "1/1000"\n'
    )
    told = "controllers.mc_ppc is controllers.ball_screw.mc_ppc"
    with pytest.raises(ScenarioError, match=told):
        compose(load_scenario(file), run_earlier)


def test_an_old_call_is_refused_with_the_new_one():
    with pytest.raises(DesignError, match=r"is controllers\.synthesis\.gantry\.design"):
        find_function("controllers.synthesis.gantry_design:averaging")


@pytest.mark.parametrize("old", sorted(MOVED))
def test_every_new_name_exists_and_no_old_one_is_a_model(old):
    assert find_spec(MOVED[old]) is not None
    assert old not in MODULES
