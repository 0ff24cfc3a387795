"""P-PI gains by margins: they land on both, and set C is found again from its own."""

import pytest
from effort import EFFORT

from controllers.synthesis.ball_screw.p_pi_tuning import margins, tune

SET_C = {"K_px": 269.84, "K_pv": 0.838, "K_iv": 2.98}
PUBLISHED = {"K_px": 229.631, "K_pv": 0.972269, "K_iv": 3.457387}


def test_the_gains_of_the_published_margins_have_them() -> None:
    found = margins("p_pi", **PUBLISHED)
    assert found["phase_margin_deg"] == pytest.approx(30.0, abs=0.03)
    assert found["s_max"] == pytest.approx(3.25, abs=0.003)


def test_tuning_lands_on_the_margins_asked_for() -> None:
    if not EFFORT.every:
        pytest.skip("--every-form tunes")
    assert tune(30.0, 3.25) == pytest.approx(PUBLISHED, rel=1e-3)
    own = margins("p_pi", **SET_C)
    found = tune(own["phase_margin_deg"], own["s_max"], SET_C["K_iv"] / SET_C["K_pv"])
    assert found == pytest.approx(SET_C, rel=1e-4)


def test_margins_that_no_gains_have_are_refused() -> None:
    if not EFFORT.every:
        pytest.skip("--every-form tunes")
    with pytest.raises(ValueError, match="no P-PI gains"):
        tune(60.0, 1.5)
