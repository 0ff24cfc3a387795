"""Composed FMUs of the ball screw with varying dynamics are an independent loop.

Position and mass move during the runs; whole controllers equal their parts.
"""

from pathlib import Path

import numpy as np
import pytest
from ball_screw_lpv_loop import Loop, milling, over_x_and_mass, scheduled
from numpy.typing import NDArray
from simulated import simulated

Array = NDArray[np.float64]
STUDY = "ball_screw_lpv"
STOP = 1.35  # s: the nut crosses 0.27 m outwards and 0.25 m on its way back


def far(got: Array, expected: Array) -> float:
    """Return the largest difference relative to the largest value.

    A row at the very stop, which is no instant of the controller, is left out.
    """
    got = got[: len(expected)]
    return float(np.max(np.abs(got - expected)) / np.max(np.abs(expected)))


def harmonic(t: float) -> float:
    return 0.72 * 0.887 / (0.02 / (2 * np.pi)) * 3 * np.sin(1350 * t)


LPV = Loop(laws=(scheduled("k_vib"),), on_motor=harmonic, stop=STOP)
IN_THE_CUT = Loop(
    mode=over_x_and_mass,
    laws=(scheduled("k_vib_region_1"), scheduled("k_vib_region_2")),
    on_table=lambda t: -milling(t, 0, np.pi / 2) if t + 1e-9 >= 0.2 else 0.0,
    mass=lambda t: 10 - 5 * max(t - 0.2, 0.0),
    r_0=0.10,
    stroke=0.34,
    stop=STOP,
)


@pytest.mark.parametrize(
    ("scenario", "loop"), [("case_2_harmonic", LPV), ("switched_cut", IN_THE_CUT)]
)
def test_a_composition_is_the_independent_loop_to_1e_9(
    scenario: str, loop: Loop, tmp_path: Path
) -> None:
    got, expected = (
        simulated(tmp_path, f"ball_screw_lpv/{scenario}", f"stop={STOP}"),
        loop.run(),
    )
    assert np.ptp(expected["u_c"]) > 0.29
    for name, signal in (("u_c", "plant.u_c"), ("v_m", "controller.v_m")):
        assert far(got[signal].values, expected[name]) < 1e-9, signal
    assert far(got["controller.e"].values, expected["e"]) < 1e-9
    if scenario == "switched_cut":
        region = got["controller.region"].values[: len(expected["region"])]
        assert np.array_equal(region, expected["region"])
        assert list(np.flatnonzero(np.diff(region) > 0)) != []
        assert list(np.flatnonzero(np.diff(region) < 0)) != []


def test_the_whole_controller_equals_its_parts_to_the_last_bit(tmp_path: Path) -> None:
    parts = simulated(tmp_path / "parts", f"{STUDY}/switched_split", f"stop={STOP}")
    observed = "controller.tracking.observe=true"
    one = simulated(
        tmp_path / "whole", "ball_screw_lpv/switched_f1", f"stop={STOP}", observed
    )
    for signal in ("plant.u_c", "controller.v_m"):
        assert np.array_equal(parts[signal].values, one[signal].values), signal
    region = parts["supervisor.region"].values
    assert np.array_equal(region, one["controller.region"].values)
