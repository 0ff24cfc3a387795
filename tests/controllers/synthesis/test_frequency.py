"""The battery against closed forms and against loops closed in state space."""

import control as ct
import numpy as np
import pytest

from controllers.synthesis.frequency import GRID_HZ, Loop, battery, poles, respond

T_S = 1e-3
W = 2 * np.pi * 20


def integrator_loop(gain):
    """Return 1/s under u = gain (r - y), with the disturbance at the input."""
    plant = ct.ss(0, [[1, 1]], 1, [[0, 0]], inputs=["u", "d"], outputs=["y"])
    controller = ct.ss([], [], [], [[-gain, gain]], 0)
    return Loop(plant, controller)


def resonant_parts(T_s=None):
    """Return a damped two-mode plant with an antiresonance and a PD-like law."""
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2:, :2] = [[-9e4, 8e4], [3.2e5, -3.3e5]]
    A[2:, 2:] = [[-20, 5], [20, -30]]
    B = np.zeros((4, 2))
    B[2, 0], B[3, 1] = 1.0, 4.0
    plant = ct.ss(A, B, np.eye(2, 4), np.zeros((2, 2)))
    low_pass = ct.ss(-900, [[1, 1, 1]], 900, [[0, 0, 0]])
    controller = low_pass * ct.ss([], [], [], np.diag([-6e4, 4e4, 2e4]))
    if T_s is None:
        return plant, controller
    return plant.sample(T_s), controller.sample(T_s, method="tustin")


def closed_by_hand(loop):
    """Close (r, d) -> y_2 in state space, delays as states."""
    controller = loop.controller
    for _ in range(loop.latency):
        controller = ct.ss(0, 1, 1, 0, loop.plant.dt) * controller
    plant = ct.ss(loop.plant, inputs=["u", "d"], outputs=["y_1", "y_2"])
    controller = ct.ss(controller, inputs=["y_1", "y_2", "r"], outputs=["u"])
    return ct.interconnect([plant, controller], inputs=["r", "d"], outputs=["y_2"])


def test_an_integrator_loop_has_its_textbook_figures():
    found = battery(respond(integrator_loop(W)))
    np.testing.assert_allclose(found.crossovers_hz, [20], rtol=1e-9)
    np.testing.assert_allclose(found.phase_margins, [np.pi / 2], rtol=1e-9)
    assert list(found.falling) == [True]
    assert found.gain_margins.size == 0
    # S = s/(s + W) never exceeds one, y/d = 1/(s + W) is largest at the low end
    assert found.s_max < 1
    np.testing.assert_allclose(found.bands_hz, [[0, 400]])
    assert found.magnitude_max == pytest.approx(1 / np.hypot(W, 2 * np.pi))
    assert found.real_min > 0


def test_a_delayed_integrator_has_its_textbook_margins():
    plant = ct.ss(0, [[1, 1]], 1, [[0, 0]]).sample(T_S)
    loop = Loop(plant, ct.ss([], [], [], [[-W]], T_S), latency=2)
    found = battery(respond(loop))
    # T_s/(z - 1) z^-2: half a sample of hold, then two of latency
    f_c = np.arcsin(W * T_S / 2) / (np.pi * T_S)
    np.testing.assert_allclose(found.crossovers_hz, [f_c], rtol=1e-8)
    margin = np.pi / 2 - 2.5 * 2 * np.pi * f_c * T_S
    np.testing.assert_allclose(found.phase_margins, [margin], rtol=1e-7)
    f_180 = 0.25 / 2.5 / T_S
    np.testing.assert_allclose(found.phase_crossovers_hz[0], f_180, rtol=1e-8)
    gain = W * T_S / (2 * np.sin(np.pi * f_180 * T_S))
    np.testing.assert_allclose(found.gain_margins[0], 1 / gain, rtol=1e-7)


@pytest.mark.parametrize(("T_s", "latency"), [(None, 0), (T_S, 0), (T_S, 1), (T_S, 3)])
def test_responses_are_those_of_the_loop_closed_in_state_space(T_s, latency):
    loop = Loop(*resonant_parts(T_s), latency)
    response = respond(loop, GRID_HZ[::40])
    closed = closed_by_hand(loop)
    s = 2j * np.pi * response.f_hz
    values = closed(s if T_s is None else np.exp(s * T_s))[0]
    np.testing.assert_allclose(response.tracking, values[0], rtol=1e-9)
    np.testing.assert_allclose(response.disturbance, values[1], rtol=1e-9)


@pytest.mark.parametrize("latency", [0, 1, 2])
def test_poles_are_those_of_the_loop_closed_in_state_space(latency):
    loop = Loop(*resonant_parts(T_S), latency)
    by_hand = np.abs(closed_by_hand(loop).poles())
    np.testing.assert_allclose(
        np.sort(np.abs(poles(loop))), np.sort(by_hand), rtol=1e-9, atol=1e-9
    )


def test_every_crossover_of_a_resonant_loop_is_found():
    response = respond(Loop(*resonant_parts()))
    found = battery(response)
    magnitude = np.abs(response.L)
    changes = np.flatnonzero(np.diff(magnitude > 1))
    assert len(changes) >= 3
    assert len(found.crossovers_hz) == len(changes)
    assert np.all(found.crossovers_hz >= GRID_HZ[changes])
    assert np.all(found.crossovers_hz <= GRID_HZ[changes + 1])
    np.testing.assert_array_equal(found.falling, magnitude[changes] > 1)
    at = respond(Loop(*resonant_parts()), found.crossovers_hz).L
    np.testing.assert_allclose(np.abs(at), 1, rtol=1e-7)
    np.testing.assert_allclose(np.exp(1j * found.phase_margins), -at, rtol=1e-7)


def test_sensitivity_bands_and_peak_are_those_of_a_finer_grid():
    loop = Loop(*resonant_parts(T_S), 1)
    found = battery(respond(loop))
    fine_hz = np.linspace(1, 400, 40_001)
    S = np.abs(1 / (1 + respond(loop, fine_hz).L))
    assert found.s_max == pytest.approx(S.max(), rel=1e-5)
    assert found.s_max_hz == pytest.approx(fine_hz[np.argmax(S)], abs=1e-2)
    inside = np.any(
        [(fine_hz > low) & (fine_hz < high) for low, high in found.bands_hz], axis=0
    )
    assert np.sum(inside != (S < 1)) <= 2 * len(found.bands_hz)


def test_a_continuous_plant_under_a_sampled_law_is_refused():
    plant, _ = resonant_parts()
    _, controller = resonant_parts(T_S)
    with pytest.raises(ValueError, match="sample the plant first"):
        Loop(plant, controller)


def test_latency_of_a_continuous_loop_is_refused():
    with pytest.raises(ValueError, match="latency counts samples"):
        Loop(*resonant_parts(), 1)
