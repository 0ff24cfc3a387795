"""Measured loops are the exact ones: zero-order hold of the plant, the traced law."""

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest
from measured_loops import composed, decibels, degrees
from numpy.typing import NDArray

from controllers.synthesis.ball_screw.loops import sampled_loop
from controllers.synthesis.frequency import respond
from orchestrator.response.measure import Response, measure

Complex = NDArray[np.complex128]


class Case(NamedTuple):
    controller: str
    latency: int
    khz: int
    encoder: bool = False


SAMPLED = [Case("mc_ppc", 1, 10), Case("p_pi", 2, 20), Case("p_pi", 1, 20, True)]
ALL = [
    Case(controller, latency, khz, encoder)
    for controller in ("mc_ppc", "p_pi")
    for latency in (0, 1, 2)
    for khz in (10, 20)
    for encoder in (False, True)
]


def ball_screw(case: Case, lowest: int = 1) -> tuple[Response, Callable[..., Complex]]:
    name = "mc_ppc" if case.controller == "mc_ppc" else "p_pi_a"
    found = measure(
        composed(
            f"ball_screw_pole_placement/{name}_track_500",
            f"controller.latency={case.latency}",
            f"rates.control={case.khz} kHz",
            f"encoder.on={str(case.encoder).lower()}",
        ),
        ["controller.u"],
        lowest=Fraction(lowest),
    )
    loop = sampled_loop(case.controller, False, {}, case.latency, 1e-3 / case.khz)
    return found, lambda hz: respond(loop, hz).L


def refuse_apart(found: Response, exact: Callable[..., Complex], noisy: bool) -> None:
    low = found.hz <= 0.25 / float(found.sample)
    S, wanted = found.S[low, 0, 0], 1 / (1 + exact(found.hz[low]))
    if noisy:  # noise is not smaller where S is
        seen = np.abs(wanted) > 0.1
        assert decibels(S[seen], wanted[seen]) < 0.1
    else:
        assert decibels(S, wanted) < 0.01
        assert degrees(S, wanted) < 0.1
    fine = np.geomspace(found.hz[0], found.hz[-1], 100_000)
    assert found.s_max[0] == pytest.approx(
        np.max(np.abs(1 / (1 + exact(fine)))), rel=0.01
    )


@pytest.mark.parametrize("case", SAMPLED, ids=str)
def test_the_ball_screws_sensitivity_is_that_of_its_exact_loop(case: Case) -> None:
    found, exact = ball_screw(case, lowest=4)
    refuse_apart(found, exact, case.encoder)


@pytest.mark.parametrize("case", [c for c in ALL if c not in SAMPLED], ids=str)
def test_every_sensitivity_is_that_of_its_exact_loop(
    case: Case, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form measures every loop")
    found, exact = ball_screw(case)
    refuse_apart(found, exact, case.encoder)
