"""The bipod's LPV designs (Hanifzadegan 2014, sec. 7.2)."""

import numpy as np
import pytest

from controllers.synthesis.bipod_lpv import designs, figures, single
from controllers.synthesis.lpv.systems import response


def test_the_weight_is_the_printed_quotient() -> None:
    s = 1j * np.geomspace(0.1, 1e5, 7)
    printed = np.polyval(single.W_E[0], s) / np.polyval(single.W_E[1], s)
    assert response(single.W_E_SYSTEM, s)[:, 0, 0] == pytest.approx(printed, rel=1e-9)


@pytest.mark.parametrize(
    ("phi_deg", "v_1", "gamma"),
    [(10, 0, 92.8), (45, 0, 98.5), (60, 0, 109.4), (80, 0, 217.7), (80, 1, 239.0)],
)
def test_frozen_plants_bound_every_design(
    phi_deg: float, v_1: float, gamma: float
) -> None:
    assert figures.frozen(phi_deg, v_1) == pytest.approx(gamma, rel=3e-3)


@pytest.mark.parametrize(
    ("name", "gamma", "dense", "table"),
    [("k_single", 256.2, 272, 272), ("k_tuned", 116.4, 123, 123)],
)
def test_shipped_designs_certify_and_are_what_the_formulas_give(
    name: str, gamma: float, dense: float, table: float
) -> None:
    found = designs.verdict(designs.read(name))
    assert found.gamma == pytest.approx(gamma, rel=0.01)
    assert found.dense[0] <= dense
    assert found.table[0] <= table
    assert found.difference < 1e-4
    if name == "k_single":
        assert found.gamma >= figures.frozen(80, 1.0)


def test_the_smooth_blend_certifies_by_the_published_descent() -> None:
    """γ falls with each step 1 and stays above the frozen bound."""
    found = figures.smooth_switching()
    steps = designs.smooth_content()["design"]["history"][::2]
    assert list(steps) == sorted(steps, reverse=True)
    assert found["dense"] <= 275
    assert found["dense"] >= figures.frozen(80, 1.0)


def test_hysteresis_has_a_synthesis_of_its_own_that_certifies() -> None:
    found = figures.hysteresis()
    assert found["gamma"] == pytest.approx(115.8, rel=0.01)
    assert found["dense"] <= 123
    assert found["links"] <= 0


def test_the_smooth_loop_is_softest_where_the_source_has_it() -> None:
    """Fig. 7.15: about 270 rad/s, and S between -110 and -150 dB at low frequency."""
    found = figures.responses(72.7)
    assert -150 < found["S_1"] < -110
    assert found["omega_peak"] == pytest.approx(270, rel=0.05)
    assert found["T_peak"] == pytest.approx(found["T_270"], abs=0.1)
