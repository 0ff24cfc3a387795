"""Figures of positioning are those of signals known in closed form."""

import numpy as np
import pytest

from orchestrator.evaluation.motion import (
    contour_error,
    onset,
    step_response,
    sustained,
)
from orchestrator.quantities.quantity import NoValue, Quantity

time = np.arange(5001) * 2e-4


def test_a_first_order_lag_rises_in_ln_9_time_constants_without_overshoot():
    tau = 0.05
    y = 3.0 * (1 - np.exp(-time / tau))
    found = step_response(time, y, 3.0, 0.003, "mm")
    assert found["rise"].value == pytest.approx(tau * np.log(9), abs=1e-6)
    assert found["overshoot"].value == 0.0
    assert found["settling"].value == pytest.approx(tau * np.log(1000), abs=2e-4)


def test_a_resonance_overshoots_by_its_damping_ratio_also_downward():
    zeta, omega = 0.4, 60.0
    omega_d = omega * np.sqrt(1 - zeta**2)
    fading = np.exp(-zeta * omega * time)
    ringing = np.cos(omega_d * time) + zeta * omega / omega_d * np.sin(omega_d * time)
    found = step_response(time, -2e-3 * (1 - fading * ringing), -2e-3, 1e-6, "m")
    expected = 100 * np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    assert found["overshoot"].value == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("level", "lost"),
    [(0.5, {"rise", "reach", "settling"}), (0.95, {"settling"}), (1.0, set())],
)
def test_a_step_that_does_not_arrive_lacks_its_times_and_keeps_its_error(level, lost):
    y = level * (1 - np.exp(-time / 0.02))
    found = step_response(time, y, 1.0, 0.01, "mm")
    assert {k for k, v in found.items() if isinstance(v, NoValue)} == lost
    assert found["error"] == Quantity(pytest.approx(1 - level), "mm")
    if level == 0.5:
        assert found["settling"].why == (
            "not settled: the error is 0.5 mm at 1 s, outside the band of 0.01 mm"
        )
        assert found["rise"].why == "90 % of height not reached: 50 % at most by 1 s"


def test_points_on_a_contour_have_no_error_and_points_outside_their_distance():
    angle = np.linspace(0, 2 * np.pi, 50)
    x, y = 5 * np.cos(angle), 5 * np.sin(angle)
    assert np.abs(contour_error(x, y, "circle", 5.0)).max() < 1e-14
    assert contour_error(1.1 * x, 1.1 * y, "circle", 5.0) == pytest.approx(0.5)
    assert contour_error(np.array([5.0, -3.0]), np.array([0.0, 2.5]), "diamond", 5) == (
        pytest.approx([0.0, 0.5])
    )


def test_the_distance_from_a_square_on_its_corner_ends_at_the_corner():
    x, y = np.array([1.0, 0.5, 0.4, -0.5, 1.2]), np.array([0.0, 0.5, -0.5, 0.7, 0.0])
    side = np.sqrt(2)
    expected = [0.0, 0.0, -0.1 / side, 0.2 / side, 0.2]
    assert contour_error(x, y, "square", side) == pytest.approx(expected, abs=1e-15)


def test_the_distance_from_a_rose_is_along_its_normal_and_outside_positive():
    phi = np.linspace(-0.6, 0.6, 25)
    r, slope = 5 * np.cos(2 * phi), -10 * np.sin(2 * phi)
    on = r * np.exp(1j * phi)
    normal = -1j * (slope + 1j * r) * np.exp(1j * phi) / np.hypot(slope, r)
    assert np.abs(contour_error(on.real, on.imag, "rose", 5.0)).max() < 1e-14
    for away in (0.02, -0.02):
        p = (on + away * normal) * 1j  # another petal
        error = contour_error(p.real, p.imag, "rose", 5.0)
        assert error == pytest.approx(away, abs=1e-12)


def test_the_first_stair_that_ends_oscillating_counts_not_one_that_rings_down():
    stair = np.floor(time / 0.2)
    since = time - 0.2 * stair
    ringing = np.exp(-since / 0.01) * np.sin(2 * np.pi * 700 * since)
    lasting = np.where(stair >= 3, np.sin(2 * np.pi * 700 * time), 0.0)
    level = 2.0 * 1.1**stair
    found = sustained(time, ringing + lasting, level, 0.2, 0.05, 0.5)
    assert found == pytest.approx(2.0 * 1.1**3)
    assert sustained(time, ringing, level, 0.2, 0.05, 0.5) is None


def ringing_under_a_ramp(limit):
    """Return a gain from 2 to 3 over a second and what decays below ``limit``."""
    gain = 2 + time
    size = np.exp(50 * (gain - limit) ** 2)
    return gain, size * np.sin(600 * time) + 1e4 * np.exp(-5 * time)


@pytest.mark.parametrize("limit", [2.3, 2.437, 2.6])
def test_a_ramped_gain_passes_its_limit_where_the_ringing_is_smallest(limit):
    gain, y = ringing_under_a_ramp(limit)
    found = onset(time, y, gain, 0.05, "1")
    assert found["limit"].value == pytest.approx(limit, abs=0.01)
    assert found["time"].value == pytest.approx(limit - 2, abs=0.01)


@pytest.mark.parametrize("limit", [1.5, 3.5])
def test_ringing_that_only_grows_or_only_decays_has_no_onset(limit):
    gain, y = ringing_under_a_ramp(limit)
    found = onset(time, y - 1e4 * np.exp(-5 * time), gain, 0.05, "1")
    assert set(found) == {"limit", "time"}
    for figure in found.values():
        assert "no onset between 2 and 3: " in figure.why
