"""Reference shapes: on the contour, with the velocity that belongs to them."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.references import circle as circle_reference
from controllers.references import current_pulse
from controllers.references import diamond as diamond_reference
from controllers.references import sine as sine_reference
from controllers.references import stair as stair_reference
from fmus.ticks import turn

T_s = 2e-4


def signals(module: Any, p: Any, n: int) -> np.ndarray:
    """Return the outputs of a source at its ticks 0 to n - 1, shape (outputs, n)."""
    k = np.arange(n, dtype=float)
    _, y = module.step(module.State(k), module.Input(), p, T_s)
    return np.array([np.broadcast_to(signal, n) for signal in y])


@given(st.floats(0.01, 900), st.integers(0, 2**27))
def test_the_phase_does_not_drift_over_hours(f_hz: float, k: int) -> None:
    exact = Fraction(f_hz * T_s) * k % 1
    found = float(turn(f_hz, float(k), T_s))
    apart = abs(found - float(exact))
    assert min(apart, 1 - apart) < 1e-14
    assert 0 <= found < 1


@pytest.mark.parametrize("t_0", [0.0, 0.05])
def test_a_circle_stays_on_its_radius_and_starts_at_rest(t_0: float) -> None:
    p = circle_reference.Parameters(R=5e-3, frequency_hz=2.0, t_0=t_0)
    x, vx, y, vy = signals(circle_reference, p, 3000)
    assert np.hypot(x, y) == pytest.approx(5e-3, rel=1e-12)
    assert (x[0], y[0]) == (0.0, 5e-3)
    first = round(t_0 / T_s)
    assert np.all(vx[:first] == 0)
    assert np.hypot(vx, vy)[first:] == pytest.approx(4 * np.pi * 5e-3, rel=1e-12)


def test_a_square_stays_on_its_sides_at_the_path_speed() -> None:
    p = diamond_reference.Parameters(D=5e-3, v=31.416e-3)
    x, vx, y, vy = signals(diamond_reference, p, 9003)
    assert np.abs(x) + np.abs(y) == pytest.approx(5e-3, abs=1e-15)
    assert np.hypot(vx, vy) == pytest.approx(31.416e-3, rel=1e-12)
    corners = np.flatnonzero(np.diff(np.sign(vx)) != 0)
    period = np.diff(corners).mean() * 2 * T_s
    assert period == pytest.approx(4 * np.sqrt(2) * 5e-3 / 31.416e-3, abs=T_s)


@pytest.mark.parametrize(
    ("module", "p", "pairs"),
    [
        (sine_reference, sine_reference.Parameters(phase=0.4), [(0, 1)]),
        (circle_reference, circle_reference.Parameters(), [(0, 1), (2, 3)]),
        (diamond_reference, diamond_reference.Parameters(), [(0, 1), (2, 3)]),
    ],
)
def test_the_velocity_is_the_rate_of_the_position(
    module: Any, p: Any, pairs: list[tuple[int, int]]
) -> None:
    found = signals(module, p, 4000)
    for position, velocity in pairs:
        rate = np.diff(found[position]) / T_s
        mean = (found[velocity][1:] + found[velocity][:-1]) / 2
        smooth = np.abs(np.diff(found[velocity])) < 1e-3
        assert rate[smooth] == pytest.approx(mean[smooth], abs=1e-7)


def test_a_stair_rises_by_equal_steps_and_then_stays() -> None:
    p = stair_reference.Parameters(height=5e-9, t_0=0.01, steps=3.0, dwell=0.02)
    x, v = signals(stair_reference, p, 600)
    t = np.arange(600) * T_s
    n = np.clip(np.floor((t - 0.01) / 0.02 + 1e-9) + 1, 0, 3)
    assert np.array_equal(x, 5e-9 * n)
    assert np.all(v == 0)


@pytest.mark.parametrize("fading", [True, False])
def test_a_pulse_is_followed_by_the_braking_that_was_asked_for(fading: bool) -> None:
    p = current_pulse.Parameters(6.0, 0.25, 0.0, 6.0, 0.1, fading)
    (u,) = signals(current_pulse, p, 2500)
    assert np.all(u[:1250] == 6)
    assert u[1250] == -6
    assert np.all(u[1750:] == 0)
    area = u[1250:1750].sum() * T_s
    assert area == pytest.approx(-0.3 if fading else -0.6, abs=1e-3)
