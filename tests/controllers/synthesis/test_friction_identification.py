"""Friction through a disturbance observer: levels of a known drive, from slow jogs."""

import numpy as np
import pytest
from effort import EFFORT

from controllers.synthesis.ball_screw.friction_identification import (
    Observed,
    identify,
    levels,
    observe,
)
from orchestrator.session import run

T_S = 5e-5


def test_a_step_of_disturbance_is_observed_with_its_size() -> None:
    n, m, b = 8000, 2.2e-3, 1e-3
    u = np.full(n, 0.5)
    d = np.where(np.arange(n) < n // 2, 0.1, 0.3)
    v = np.zeros(n + 1)
    for k in range(n):
        v[k + 1] = v[k] + T_S * (u[k] - b * v[k] - d[k]) / m
    x = np.concatenate([[0.0], np.cumsum(T_S * v[1:n])])
    found = observe(u, x, T_S, m, b, 1e-6, 2.0)
    assert np.mean(found.d[1000:3000]) == pytest.approx(0.1, rel=0.01)
    assert np.mean(found.d[5000:7000]) == pytest.approx(0.3, rel=0.01)
    # smoothed: half of the step is seen at its instant
    assert found.d[n // 2] == pytest.approx(0.2, abs=0.03)


def test_a_run_in_one_direction_is_refused() -> None:
    with pytest.raises(ValueError, match="both ways"):
        levels(Observed(np.full(500, 3.0), np.full(500, 0.1)))


def test_levels_of_the_jogged_drive_are_recovered() -> None:
    if not EFFORT.every:
        pytest.skip("--every-form jogs")
    done = run("ball_screw_pole_placement/friction_jogs", report=False)
    u, y = done["jogs.u"].values, done["encoder.y_1"].values
    found = identify(u, y, T_S, 1.858e-3, 0.379e-3, 1.020e-3, 0.0)
    known = {"d_c_plus": 0.14, "d_c_minus": 0.11, "d_s_plus": 0.23, "d_s_minus": 0.19}
    known["Omega"] = 2.5
    assert found == pytest.approx({f"friction.{k}": v for k, v in known.items()}, 0.01)
