"""Singular values, crossings and turns of loops whose answer is known."""

import control as ct
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.synthesis.frequency import Loop
from controllers.synthesis.multivariable import (
    bands_below,
    clockwise_turns,
    crossings,
    poles,
    respond,
    upper,
)

T_s = 1e-3


def loop(gains, latency=1):
    """Two integrators, each under a gain of its own."""
    plant = ct.ss(np.eye(2), T_s * np.eye(2), np.eye(2), 0, T_s)
    controller = ct.ss([], [], [], -np.diag(gains), T_s)
    return Loop(plant, controller, latency)


def test_decoupled_loops_have_the_singular_values_of_each():
    response = respond(loop([100.0, 300.0], latency=0), np.array([5.0, 20.0]))
    z = np.exp(2j * np.pi * response.f_hz * T_s)
    expected = 300 * T_s / np.abs(z - 1)
    assert upper(response.L) == pytest.approx(expected)
    assert upper(response.S)[0] == pytest.approx(abs(1 / (1 + 100 * T_s / (z[0] - 1))))


@settings(max_examples=10)
@given(gains=st.lists(st.floats(10, 3000), min_size=2, max_size=2))
def test_the_turns_count_the_poles_outside_the_unit_circle(gains):
    # one sample of delay: unstable from a gain of 1/T_s on
    found = loop(gains)
    outside = np.sum(np.abs(poles(found)) > 1 + 2e-5)
    near = np.min(np.abs(np.abs(poles(found)) - 1))
    if near > 1e-3:
        assert clockwise_turns(found) == outside


def test_late_samples_are_poles_of_the_loop():
    assert len(poles(loop([100.0, 100.0], latency=3))) == 8


def test_a_plant_that_was_not_sampled_is_refused():
    continuous = ct.ss(-np.eye(2), np.eye(2), np.eye(2), 0)
    with pytest.raises(ValueError, match="sample the plant first"):
        Loop(continuous, loop([1.0, 1.0]).controller)


def test_power_laws_cross_exactly_between_grid_points():
    f_hz = np.geomspace(1, 100, 7)
    assert crossings(f_hz, (f_hz / 17.0) ** -2) == pytest.approx([17.0])
    assert crossings(f_hz, f_hz / 17.0, level=2.0) == pytest.approx([34.0])


def test_bands_below_one_reach_from_zero_to_the_end_of_the_grid():
    f_hz = np.geomspace(1, 1000, 400)
    hill = 2 * np.exp(-(np.log(f_hz / 30) ** 2))
    low, high = bands_below(f_hz, hill)
    edge = np.exp(np.sqrt(np.log(2)))
    assert low == pytest.approx([0.0, 30 / edge], rel=1e-3)
    assert high == pytest.approx([30 * edge, 1000.0], rel=1e-3)
