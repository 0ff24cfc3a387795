"""LPV designs for an axis of the serial machine (Hanifzadegan 2014, sec. 7.1)."""

import pytest

from controllers.synthesis.serial_lpv import designs, figures, single


@pytest.mark.parametrize(
    ("x_c", "disturbed", "undisturbed"),
    [(0.2, 23.80, 15.54), (0.4, 23.84, 15.56), (0.6, 23.86, 15.57)],
)
def test_the_published_gamma_lies_below_the_frozen_optimum(
    x_c: float, disturbed: float, undisturbed: float
) -> None:
    """13 is below both: no controller reaches it with the printed data."""
    assert figures.frozen(x_c) == pytest.approx(disturbed, rel=5e-3)
    off = figures.frozen(x_c, single.UNDISTURBED)
    assert off == pytest.approx(undisturbed, rel=5e-3)
    assert off > 13


@pytest.mark.parametrize(
    ("name", "bound", "dense"),
    [("k_undisturbed", 15.5, 17.5), ("k_disturbed", 23.8, 27)],
)
def test_shipped_designs_certify_with_their_tables(
    name: str, bound: float, dense: float
) -> None:
    """With the disturbance on as well, which was thought to have no solution."""
    found = designs.verdict(designs.read(name))
    assert bound < found.gamma < 1.03 * bound
    assert max(*found.dense, *found.table) <= dense
    assert found.difference < 1e-3


def test_the_smooth_blend_certifies_and_turns_more_slowly_than_its_start() -> None:
    found = figures.smooth_switching()
    steps = designs.smooth_content()["design"]["history"][::2]
    assert list(steps) == sorted(steps, reverse=True)
    assert 15.5 < found["dense"] <= 1.02 * 16.7
    assert found["table"] <= 1.02 * 16.7
    assert found["eta"] < found["eta_begun"] / 100


@pytest.mark.parametrize(("case", "dense"), [("", 17.5), ("_disturbed", 27)])
def test_two_controllers_with_hysteresis_certify_with_their_tables(
    case: str, dense: float
) -> None:
    found = figures.hysteresis(case)
    assert found["dense"] <= dense


def test_with_the_disturbance_on_the_blend_is_better_than_one_controller() -> None:
    """γ_d of the bisection is reached, and η is an eighth of the start's."""
    about = designs.smooth_content("_disturbed")["design"]
    wanted, reached = about["gamma_d"][-1]
    assert reached == about["history"][-1] <= wanted
    found = figures.smooth_switching("_disturbed")
    assert 23.86 < max(found["dense"], found["table"]) < 24.8
    assert found["eta"] < found["eta_begun"] / 8
