"""Parameters and start values written with a unit."""

import pytest

from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario

SCENARIO = "ball_screw_pole_placement/p_pi_a_track_500"


def composed(*overrides):
    def no_run(name):
        raise AssertionError(name)

    return compose(load_scenario(SCENARIO, overrides), no_run)


def test_a_value_with_a_unit_becomes_a_number_of_the_variable():
    found = composed("plant.r_g=3.2 mm/rad", "plant.state.x_1=180 deg", "plant.b_2=0")
    plant = found.system.components["plant"]
    assert plant.parameters == {"r_g": 3.2e-3, "b_2": 0.0}
    assert plant.start["state.x_1"] == pytest.approx(3.141592653589793)
    assert found.parameter("plant.r_g").to("mm/rad").value == 3.2


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("plant.r_g=3 kg", 'plant.parameters.r_g = "3 kg": kg cannot become m/rad'),
        ("plant.r_g=fast", "'fast' is not a number with a unit"),
        ('plant.m_1="8"', "a pure number cannot become V.s2/rad"),
        ("plant.m_3=8 kg", "no variable 'm_3'; did you mean 'm_2'"),
        ("plant.r_g=3 mm/rat", "unknown unit 'rat' in 'mm/rat'; did you mean"),
        ("plant.m_1=8 Hz", "Hz cannot become V.s2/rad"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused_with_its_place(override, said):
    with pytest.raises(ScenarioError, match=said):
        composed(override)
