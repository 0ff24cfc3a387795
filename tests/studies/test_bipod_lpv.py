"""What the study of the bipod must show, through its FMUs."""

from pathlib import Path

import numpy as np
import pytest
from bipod_loop import Loop
from numpy.typing import NDArray
from simulated import far, simulated

from orchestrator.reproduction.reproduce import reproduce

Array = NDArray[np.float64]
ROUGH = ("plant.friction.on=true", "plant.g=9.81")


def test_figures_are_within_the_tolerances_of_the_study(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Errors under the disturbance; every figure with --every-form."""
    whole = request.config.getoption("--every-form")
    only = "*" if whole else "bipod.[!T]*.e_fd"
    figures = reproduce("bipod_lpv", only, processes=1, folder=tmp_path).figures
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    assert len(figures) > (40 if whole else 3)


@pytest.mark.parametrize("scenario", ["lpv_disturbed", "tool_circle_disturbed"])
@pytest.mark.parametrize("rough", [(), ROUGH])
def test_the_mechanism_neither_makes_nor_loses_energy(
    scenario: str, rough: tuple[str, ...], tmp_path: Path
) -> None:
    got = simulated(tmp_path, f"bipod_lpv/{scenario}", *rough)
    balance = got["plant.E"].values - got["plant.W"].values
    assert np.ptp(got["plant.E"].values) > 4
    assert np.ptp(balance) < 1e-9


@pytest.mark.parametrize("controller", ["lpv", "hysteresis", "smooth"])
def test_a_composition_is_the_independent_loop_to_1e_9(
    controller: str, tmp_path: Path
) -> None:
    """Until 1.6 s the rods pass 70 and 75.4 deg both ways."""
    got = simulated(tmp_path, f"bipod_lpv/{controller}_disturbed", "stop=1.6")
    expected = Loop(controller).run(1.6)
    for name, signal in (
        ("x_1", "plant.x_1"),
        ("e", "controller.e"),
        ("f_1", "controller.f_1"),
    ):
        assert far(got[signal].values, expected[name]) < 1e-9, signal
    if controller == "hysteresis":
        region = got["controller.region"].values
        assert np.array_equal(region, expected["region"])
        assert set(np.diff(region)) == {-1.0, 0.0, 1.0}
