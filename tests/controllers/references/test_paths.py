"""Lines, circles and diamonds are where they should be, with true derivatives."""

import numpy as np
import pytest

from controllers.references import circle_path, diamond_path, line_path
from controllers.references._path import Input, State

T_s = 1 / 15_000


def command(module, p, k):
    _, y = module.step(
        State(np.asarray(k, float)), Input(), p, T_s, module.prepare(p, T_s)
    )
    return y


PATHS = [
    (line_path, line_path.Parameters(x_0=-0.05, stroke_x=0.12, stroke_y=-0.16)),
    (circle_path, circle_path.Parameters(x_0=0.01, turns=-1.0)),
    (diamond_path, diamond_path.Parameters(y_0=0.02)),
]
NAMES = ["line", "circle", "diamond"]


@pytest.mark.parametrize(("module", "p"), PATHS, ids=NAMES)
def test_velocity_and_acceleration_are_the_derivatives(module, p):
    h = 1e-5  # a sample time of its own, so that neighbours are near
    k = np.arange(20_000.0)[:, None] * 16 + np.arange(3)
    _, y = module.step(State(k), Input(), p, h, module.prepare(p, h))
    for q, v, a in ((y.x_r, y.v_xr, y.a_xr), (y.y_r, y.v_yr, y.a_yr)):
        # constant snap: third differences hold to h² S/6
        assert (q[:, 2] - q[:, 0]) / (2 * h) == pytest.approx(v[:, 1], abs=2e-8)
        assert (v[:, 2] - v[:, 0]) / (2 * h) == pytest.approx(a[:, 1], abs=2e-6)


@pytest.mark.parametrize(("module", "p"), PATHS, ids=NAMES)
def test_the_motion_keeps_its_limits_and_reaches_them(module, p):
    y = command(module, p, np.arange(75_000))
    speed = np.hypot(y.v_xr, y.v_yr)
    assert np.max(speed) == pytest.approx(0.2, rel=1e-9)
    tangential = np.gradient(speed, T_s)
    assert np.max(np.abs(tangential)) == pytest.approx(2.0, rel=1e-3)


def test_a_line_ends_on_its_stroke_after_the_time_of_the_study():
    p = line_path.Parameters()
    y = command(line_path, p, [0, 17_249, 17_250, 10**6])
    assert y.y_r[0] == 0.0
    assert 0 < 0.2 - y.y_r[1] < 5e-15  # S T_s⁴/24
    assert y.y_r[2:] == pytest.approx([0.2, 0.2], abs=1e-16)
    assert not np.any(y.x_r)


def test_the_slow_line_takes_the_time_of_the_study():
    p = line_path.Parameters(
        stroke_y=1e-3, v_max=1e-3, a_max=2.8e-3, j_max=1e-2, s_max=4e-4 / 2.8e-3
    )
    y = command(line_path, p, np.arange(27_000))
    moving = np.flatnonzero(np.abs(y.v_yr) > 0)
    assert (moving[-1] + 1) * T_s == pytest.approx(1.70714, abs=3e-4)


def test_every_point_of_a_circle_has_its_radius_and_it_closes():
    p = circle_path.Parameters(x_0=0.01, y_0=-0.02)
    y = command(circle_path, p, np.arange(51_000))
    assert np.hypot(y.x_r - 0.01, y.y_r + 0.02) == pytest.approx(0.1, abs=1e-16)
    assert (y.x_r[0], y.y_r[0]) == (0.11, -0.02)
    assert (y.x_r[-1], y.y_r[-1]) == pytest.approx((0.11, -0.02), abs=1e-15)
    assert y.y_r[10_000] > 0  # towards positive y


def test_a_diamond_stops_in_its_corners_on_a_tick():
    p = diamond_path.Parameters()
    h = 0.2 * np.sqrt(0.5)
    y = command(diamond_path, p, np.arange(70_001))
    at = 17_250 * np.arange(5)
    corners = [(h, 0), (0, h), (-h, 0), (0, -h), (h, 0)]
    assert np.column_stack([y.x_r, y.y_r])[at] == pytest.approx(
        np.array(corners), abs=1e-15
    )
    assert np.column_stack([y.v_xr, y.v_yr, y.a_xr, y.a_yr])[at] == pytest.approx(0)
    assert np.abs(y.x_r) + np.abs(y.y_r) == pytest.approx(h, abs=1e-15)
    ramped = command(diamond_path, p._replace(dwell=0.01), 17_250 + np.arange(150))
    assert ramped.y_r == pytest.approx(h, abs=1e-15)
