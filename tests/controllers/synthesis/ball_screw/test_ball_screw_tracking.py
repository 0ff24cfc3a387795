"""How the ball-screw loops follow: feed-forward, error coefficients, prefilter."""

import numpy as np
import pytest
from ball_screw_numbers import K_I2, K_X1, M_2, SET_A, T_S, K

from controllers.ball_screw import rotary_command
from controllers.references import trajectory
from controllers.synthesis.ball_screw.loops import (
    sampled_loop,
    tracking,
)
from controllers.synthesis.linearise import linearise
from controllers.synthesis.prefilter import identify


@pytest.mark.parametrize(
    ("f_hz", "options", "magnitude", "phase"),
    [
        (80, {}, 1.057, -0.85),
        (120, {}, 1.039, -3.8),
        (80, {"inversion.on": False}, 1.387, -44.0),
        (120, {"inversion.on": False}, 0.594, -38.0),
        (20, {}, 1.0023, None),
    ],
)
def test_feed_forward_flattens_the_tracking_response(f_hz, options, magnitude, phase):
    found = tracking("mc_ppc", f_hz, **options)
    assert found["magnitude"] == pytest.approx(magnitude, abs=6e-4)
    if phase is not None:
        assert found["phase"] == pytest.approx(phase, abs=0.6)


def test_the_cascade_with_feed_forward_peaks_below_its_second_crossover():
    found = tracking("p_pi", 80)
    assert found["magnitude"] == pytest.approx(2.55, abs=5e-3)


def test_the_prefilter_flattens_the_tracking_response_at_low_frequency():
    gains = {"K_vel": -5e-9, "K_acc": 2.537e-7, "K_jerk": 8e-11, "K_snap": 4.6e-12}
    for f_hz, magnitude in ((20, 0.9998), (80, 1.037), (120, 1.087)):
        found = tracking("mc_ppc", f_hz, **gains)
        assert found["magnitude"] == pytest.approx(magnitude, abs=1e-3)


def low_frequency(error, controller, order):
    """Extrapolate an error coefficient, error / ω^order, to zero frequency."""
    f_hz = np.array([0.5, 1.0])
    values = [tracking(controller, f)[error] for f in f_hz]
    near, far = values / (2 * np.pi * f_hz) ** order
    return (4 * near - far) / 3


def test_acceleration_error_of_mc_ppc_is_the_delay_of_the_rotary_command():
    G_r = linearise(rotary_command.model, inputs=["x_r"])
    step = 1e-4
    phase = np.angle(G_r(np.exp([1j * step, 2j * step])))
    tau_r = -(8 * phase[0] - phase[1]) / (6 * step) * T_S
    assert tau_r == pytest.approx(28.0887e-6, rel=2e-6)
    K_acc = -low_frequency("error_real", "mc_ppc", 2)
    assert K_acc == pytest.approx(K_X1 * tau_r / K_I2, rel=1e-4)
    assert K_acc == pytest.approx(2.53498e-7, rel=1e-5)
    assert abs(low_frequency("error_imag", "mc_ppc", 1)) < 1e-10


def test_jerk_error_of_the_cascade_is_the_wind_up_of_the_screw():
    K_jerk = -low_frequency("error_imag", "p_pi", 3)
    assert K_jerk == pytest.approx(M_2 / K / SET_A["K_px"], rel=2e-3)
    assert K_jerk == pytest.approx(9.553e-9, rel=2e-3)


def move_of_500_mm_per_s():
    """Return the command (rad) over 20 ms rest, the move and 150 ms rest."""
    p = trajectory.Parameters()
    derived = trajectory.prepare(p, T_S)
    x = trajectory.State()
    x_r = np.empty(round((float(trajectory.move_time(p)) + 0.17) / T_S) + 1)
    for k in range(len(x_r)):
        x, y = trajectory.step(x, trajectory.Input(), p, T_S, derived)
        x_r[k] = y.x_r
    return x_r


def tracking_error(x_r, **parameters):
    """Run plant, one sample of latency and law over a command; shape (n,) (rad)."""
    loop = sampled_loop("mc_ppc", False, parameters, 1)
    plant, law = loop.plant, loop.controller
    x, q, u = np.zeros(plant.nstates), np.zeros(law.nstates), 0.0
    e_2 = np.empty(len(x_r))
    for k, command in enumerate(x_r):
        y = plant.C @ x
        read = np.array([*y, command, 0, 0, 0, 0])
        u_next = (law.C @ q + law.D @ read)[0]
        q = law.A @ q + law.B @ read
        x = plant.A @ x + plant.B[:, 0] * u
        e_2[k], u = command - y[1], u_next
    return e_2


def test_the_identified_prefilter_is_the_closed_form_and_cancels_the_error():
    um = 1e6 * 0.020 / (2 * np.pi)
    x_r = move_of_500_mm_per_s()
    plain = tracking_error(x_r)
    assert np.max(np.abs(plain)) * um == pytest.approx(2.490, abs=0.005)
    assert np.sqrt(np.mean(plain**2)) * um == pytest.approx(0.818, abs=0.003)
    gains = identify(x_r, x_r - plain, T_S)
    assert gains["K_acc"] == pytest.approx(2.53498e-7, rel=1e-3)
    assert gains["K_acc"] == pytest.approx(2.537e-7, rel=5e-4)
    filtered = tracking_error(x_r, **gains)
    assert np.max(np.abs(filtered)) * um == pytest.approx(0.063, abs=0.01)
