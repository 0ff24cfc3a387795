"""The rose is where it should be; the frame turns with it and does not wrap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.three_axis import rose, task_frame


def path(p: rose.Parameters, T_s: float) -> np.ndarray:
    """Return the outputs over the whole path, one row per tick."""
    x, rows = rose.State(), []
    for _ in range(round(p.T / T_s) + 1):
        x, y = rose.step(x, rose.Input(), p, T_s)
        rows.append(y)
    return np.array(rows)


def turning(found: np.ndarray, T_s: float) -> np.ndarray:
    """Return the rate of the tangent's angle between ticks (rad/s)."""
    t = found[:, 4] + 1j * found[:, 5]
    return np.angle(t[1:] / t[:-1]) / T_s


@pytest.mark.parametrize(
    ("t_r", "fastest", "slowest", "speed"),
    [(0.0, 6.2832, 2.5133, 0.125664), (0.5, 6.98132, 0.0, 0.139626)],
)
def test_the_rose_keeps_its_limits(
    t_r: float, fastest: float, slowest: float, speed: float
) -> None:
    T_s = 1e-4
    found = path(rose.Parameters(t_r=t_r), T_s)
    assert np.max(np.abs(found[:, :2])) == pytest.approx(0.05, abs=1e-9)
    rate = turning(found, T_s)
    assert np.sum(rate) * T_s == pytest.approx(6 * np.pi, abs=1e-9)
    assert np.max(rate) == pytest.approx(fastest, rel=1e-5)
    assert np.min(rate) >= slowest - 1e-4
    assert np.max(np.hypot(found[:, 2], found[:, 3])) == pytest.approx(speed, rel=1e-5)


def test_velocity_is_the_rate_of_the_command_along_the_tangent() -> None:
    T_s = 1e-4
    found = path(rose.Parameters(), T_s)
    central = (found[2:, :2] - found[:-2, :2]) / (2 * T_s)
    assert central == pytest.approx(found[1:-1, 2:4], abs=2e-7)
    assert np.hypot(found[:, 4], found[:, 5]) == pytest.approx(1.0, abs=1e-14)
    across = found[:, 2] * found[:, 5] - found[:, 3] * found[:, 4]
    assert np.max(np.abs(across)) < 1e-16


@given(
    st.floats(-7, 7), st.floats(-1, 1), st.floats(-1, 1), st.sampled_from([-1, 0, 1])
)
def test_the_frame_is_a_rotation_whatever_the_turn(
    theta: float, e_x: float, e_y: float, turns: int
) -> None:
    u = task_frame.Input(
        r_x=e_x,
        r_y=e_y,
        t_x=float(np.cos(theta + 2 * np.pi * turns)),
        t_y=float(np.sin(theta + 2 * np.pi * turns)),
    )
    _, y = task_frame.step(task_frame.State(), u, task_frame.Parameters(), 1e-3)
    assert y.e_t**2 + y.e_n**2 == pytest.approx(e_x**2 + e_y**2, abs=1e-14)
    assert y.e_t == pytest.approx(np.cos(theta) * e_x + np.sin(theta) * e_y, abs=1e-14)
    assert y.e_n == pytest.approx(np.cos(theta) * e_y - np.sin(theta) * e_x, abs=1e-14)


def test_the_delayed_estimate_of_a_late_follower_on_the_path_is_zero() -> None:
    """A table that runs 30 ms behind on the path itself has no contour error."""
    T_s, late = 1e-3, 30
    found = path(rose.Parameters(), T_s)
    x, rows = task_frame.State(), []
    for k, row in enumerate(found[:2500]):
        u_c = found[max(k - late, 0), :2]
        u = task_frame.Input(*row, *u_c)
        x, y = task_frame.step(x, u, task_frame.Parameters(), T_s)
        rows.append(y)
    e_n, e_nd = (np.array([getattr(r, n) for r in rows])[600:] for n in ("e_n", "e_nd"))
    assert np.max(np.abs(e_nd)) < 0.02 * np.max(np.abs(e_n))
