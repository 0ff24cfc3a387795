"""Loops by margins: known gains are found again, and none stiffer keep the margins."""

import numpy as np
import pytest

from controllers.synthesis.xy_table.loop_design import (
    Gains,
    axis,
    by_margins,
    disturbance,
    from_run,
    margins,
    position_loop,
    speed_loop,
    stiffest,
)
from controllers.synthesis.xy_table.loops import figures
from orchestrator.session import run

DRIVE = {"b": 78020.0, "a_1": 163.0, "a_0": 193.3, "tau": 1.2e-3}
PUBLISHED = {"k_p": 0.006607, "k_i": 0.12075, "k_v": 225.0}


def test_the_published_gains_are_found_again_from_their_own_margins() -> None:
    own = figures()
    wanted = [own[f"speed_{of}_margin"] for of in ("gain", "phase")]
    found = by_margins(*DRIVE.values(), *wanted, own["position_gain_margin"])
    assert found == pytest.approx(PUBLISHED, rel=2e-5)


def test_the_loops_designed_have_the_margins_asked_for() -> None:
    found = figures(**by_margins(**DRIVE))
    assert found["speed_gain_margin"] == pytest.approx(9.31, abs=1e-4)
    assert found["speed_phase_margin"] == pytest.approx(56.4, abs=1e-3)
    assert found["position_gain_margin"] == pytest.approx(9.1, abs=1e-4)


def test_no_neighbour_is_stiffer_at_the_margins_asked_for() -> None:
    G, best = axis(**DRIVE), Gains(**stiffest(**DRIVE, gain_db=9.0, phase_deg=55.0))

    def kept(gains: Gains) -> bool:
        L_v = speed_loop(G, gains.k_p, gains.k_i / gains.k_p)
        loops = margins(L_v), margins(position_loop(L_v, gains.k_v))
        gain, phase = 10 ** (9.0 / 20) * (1 - 1e-4), np.deg2rad(55.0) - 1e-4
        return all(one.gain >= gain and one.phase >= phase for one in loops)

    assert kept(best)
    generator = np.random.default_rng(1)
    for moved in np.exp(generator.normal(scale=0.05, size=(300, 3))):
        one = Gains(*(moved * best))
        if one.k_v * one.k_i > best.k_v * best.k_i * 1.002:
            assert not kept(one)
    # the low-frequency asymptote that is maximised
    exact = disturbance(G, best)[0] / (1j * 0.1) * best.k_v * best.k_i
    assert exact == pytest.approx(1.0, rel=2e-3)


def test_gains_from_a_noisy_run_are_those_of_the_drive_within_a_percent() -> None:
    done = run("cascade_nppi/identification", report=False)
    u, y = done["source.d"].values, done["sensor.y"].values
    found, exact = from_run(u, y, 5e-4), by_margins(**DRIVE)
    assert found == pytest.approx(exact, rel=0.01)


def test_margins_that_no_gains_have_are_refused() -> None:
    with pytest.raises(ValueError, match="phase margins from"):
        by_margins(**DRIVE, speed_gain_db=4.0, speed_phase_deg=70.0)
    with pytest.raises(ValueError, match="no gains keep"):
        stiffest(**DRIVE, gain_db=6.0, phase_deg=120.0)
