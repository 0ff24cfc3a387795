"""The ball-screw loops against independent figures and transfer functions."""

import numpy as np
import pytest
from ball_screw_numbers import (
    B_1,
    B_2,
    K_I2,
    K_V1,
    K_V2,
    K_X1,
    K_X2,
    M_1,
    M_2,
    SET_A,
    SET_B,
    T_S,
    C,
    K,
)
from scipy import signal

from controllers.synthesis.ball_screw.loops import (
    continuous_loop,
    figures,
    plant_figures,
    sampled_loop,
)
from controllers.synthesis.frequency import GRID_HZ, battery, poles, respond
from controllers.synthesis.matched import factored, matched

F_HZ = GRID_HZ[::20]


def transfer_functions(s):
    """Return G_11, G_21, G_23 and 1/den of eq. 3.4."""
    a_1 = M_1 * B_2 + M_2 * B_1 + (M_1 + M_2) * C
    a_2 = B_1 * B_2 + (B_1 + B_2) * C + (M_1 + M_2) * K
    den = M_1 * M_2 * s**4 + a_1 * s**3 + a_2 * s**2 + (B_1 + B_2) * K * s
    nut = C * s + K
    return (
        (M_2 * s**2 + B_2 * s + nut) / den,
        nut / den,
        (M_1 * s**2 + B_1 * s + nut) / den,
        1 / den,
    )


def filter_sections():
    """Return low-pass and notches of eq. 3.9, 3.10."""
    w = 2 * np.pi * 2000
    yield factored([w], [1, w])
    for f_hz, zeta_z, zeta_p in ((420, 0.55, 0.7), (1080, 0.05, 0.7)):
        w = 2 * np.pi * f_hz
        yield factored([1, 2 * zeta_z * w, w * w], [1, 2 * zeta_p * w, w * w])


def value(G, at):
    zeros = np.prod(at[:, None] - G.zeros, axis=1)
    return G.gain * zeros / np.prod(at[:, None] - G.poles, axis=1)


def laws(controller, rate, integral, G_fp):
    """Return the gains from y_1 and y_2 to -u, given s or its sampled likeness."""
    if controller == "mc_ppc":
        K_2 = K_X2 + K_I2 * integral + K_V2 * rate
        return (K_X1 + K_V1 * rate) * G_fp, K_2 * G_fp
    velocity = (SET_A["K_pv"] + SET_A["K_iv"] * integral) * G_fp
    return velocity * rate, velocity * SET_A["K_px"]


@pytest.mark.parametrize("controller", ["mc_ppc", "p_pi"])
def test_the_continuous_loop_is_that_of_the_transfer_functions(controller):
    s = 2j * np.pi * F_HZ
    G_11, G_21, G_23, over_den = transfer_functions(s)
    G_fp = np.prod([value(section, s) for section in filter_sections()], axis=0)
    C_1, C_2 = laws(controller, s, 1 / s, G_fp)
    L = C_1 * G_11 + C_2 * G_21
    # G_11 G_23 - G_13 G_21 = 1/den: no cancellation
    disturbance = (G_23 + C_1 * over_den) / (1 + L)
    response = respond(continuous_loop(controller, False, {}), F_HZ)
    np.testing.assert_allclose(response.L, L, rtol=1e-9)
    np.testing.assert_allclose(response.disturbance, disturbance, rtol=1e-7)


@pytest.mark.parametrize("latency", [0, 1, 2])
@pytest.mark.parametrize("controller", ["mc_ppc", "p_pi"])
def test_the_sampled_loop_is_that_of_the_difference_equations(controller, latency):
    A = [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-K / M_1, K / M_1, -(C + B_1) / M_1, C / M_1],
        [K / M_2, -K / M_2, C / M_2, -(C + B_2) / M_2],
    ]
    B = [[0, 0], [0, 0], [1 / M_1, 0], [0, 1 / M_2]]
    system = (np.array(A), np.array(B), np.eye(2, 4), np.zeros((2, 2)))
    A_d, B_d, C_d, _, _ = signal.cont2discrete(system, T_S)
    z = np.exp(2j * np.pi * F_HZ * T_S)
    P = C_d @ np.linalg.solve(z[:, None, None] * np.eye(4) - A_d, B_d[None])

    G_fp = np.prod([value(matched(g, T_S), z) for g in filter_sections()], axis=0)
    rate = (1 - 1 / z) / T_S
    C_1, C_2 = laws(controller, rate, 1 / rate, G_fp * z**-latency)
    L = C_1 * P[:, 0, 0] + C_2 * P[:, 1, 0]
    u_d = -(C_1 * P[:, 0, 1] + C_2 * P[:, 1, 1]) / (1 + L)
    response = respond(sampled_loop(controller, False, {}, latency), F_HZ)
    np.testing.assert_allclose(response.L, L, rtol=1e-8)
    np.testing.assert_allclose(
        response.disturbance, P[:, 1, 1] + P[:, 1, 0] * u_d, rtol=1e-6
    )


def test_plant_poles_are_the_published_ones():
    found = plant_figures()
    assert found["axial_frequency"] == pytest.approx(129.9993, abs=5e-5)
    assert found["axial_damping"] == pytest.approx(0.0272813, abs=5e-8)
    assert found["real_pole"] == pytest.approx(0.07257, abs=5e-6)


# key -> value and tolerance; digits of an independent computation
MC_PPC = {
    "crossover_1": (100.77, 0.01),
    "rise_1": (120.75, 0.01),
    "crossover_2": (163.69, 0.01),
    "crossover_1_current": (99.49, 0.01),
    "crossover_2_current": (159.75, 0.01),
    "crossover_1_z": (101.04, 0.01),
    "crossover_2_z": (164.26, 0.01),
    "phase_margin_min": (43.5, 0.05),
    "phase_margin_min_z": (37.7, 0.05),
    "phase_margin_min_current": (23.6, 0.05),
    "phase_margin_min_z_current": (18.0, 0.05),
    "s_max": (1.420, 0.0005),
    "s_max_frequency": (193.9, 0.1),
    "s_max_z": (1.629, 0.0005),
    "s_max_frequency_z": (189.1, 0.1),
    "s_max_current": (2.518, 0.0005),
    "s_max_frequency_current": (166.9, 0.1),
    "s_max_z_current": (3.294, 0.0005),
    "s_max_frequency_z_current": (165.5, 0.1),
    "band_1_from": (0, 0),
    "band_1_to": (145.1, 0.05),
    "band_1_to_z": (86.3, 0.05),
    "band_2_from_z": (103.0, 0.05),
    "band_2_to_z": (143.4, 0.05),
    "band_1_to_current": (72.9, 0.05),
    "band_2_from_current": (111.4, 0.05),
    "band_2_to_current": (139.7, 0.05),
    "real_min": (-0.00989, 5e-6),
    "real_min_frequency": (143.3, 0.1),
    "real_min_z": (-0.00960, 5e-6),
    "real_min_frequency_z": (144.0, 0.1),
    "real_min_current": (-0.00860, 5e-6),
    "real_min_frequency_current": (151.0, 0.1),
    "real_min_z_current": (-0.00834, 5e-6),
    "real_min_frequency_z_current": (154.5, 0.1),
    "radius": (0.99365, 1e-5),
}
P_PI_A = {
    "crossover_1": (71.84, 0.01),
    "crossover_2": (141.24, 0.01),
    "crossover_1_current": (71.19, 0.01),
    "crossover_2_current": (140.36, 0.01),
    "phase_margin_min": (30.4, 0.05),
    "phase_margin_min_z": (28.0, 0.05),
    "phase_margin_min_current": (21.4, 0.05),
    "phase_margin_min_z_current": (18.9, 0.05),
    "s_max": (2.245, 0.0005),
    "s_max_z": (2.356, 0.0005),
    "s_max_current": (2.863, 0.0005),
    "s_max_z_current": (3.243, 0.0005),
    "band_1_to": (46.4, 0.05),
    "band_2_from": (122.3, 0.05),
    "band_2_to": (165.1, 0.05),
    "band_1_to_current": (45.0, 0.05),
    "band_2_from_current": (120.9, 0.06),
    "band_2_to_current": (148.7, 0.05),
    "band_1_to_z_current": (45.0, 0.05),
    "band_2_from_z_current": (120.5, 0.05),
    "band_2_to_z_current": (146.3, 0.05),
    "real_min": (-0.01432, 5e-6),
    "real_min_frequency": (127.2, 0.1),
    "real_min_z": (-0.01321, 5e-6),
    "real_min_frequency_z": (127.7, 0.1),
    "radius": (0.99581, 1e-5),
}
P_PI_B = {
    "crossover_1": (65.99, 0.01),
    "crossover_2": (138.89, 0.01),
    "s_max": (2.941, 0.0005),
    "s_max_z_current": (3.116, 0.0005),
}


@pytest.mark.parametrize(
    ("controller", "gains", "printed"),
    [("mc_ppc", {}, MC_PPC), ("p_pi", SET_A, P_PI_A), ("p_pi", SET_B, P_PI_B)],
    ids=["mc_ppc", "p_pi_a", "p_pi_b"],
)
def test_figures_are_those_computed_independently(controller, gains, printed):
    found = figures(controller, **gains)
    wrong = {
        key: (found.get(key), expected)
        for key, (expected, tolerance) in printed.items()
        if abs(found.get(key, np.nan) - expected) > tolerance or key not in found
    }
    assert not wrong


def test_without_filter_pack_the_second_crossover_is_at_171_hz():
    without = {
        "filters.zeta_z1": 0.7,
        "filters.zeta_z2": 0.7,
        "filters.omega_lpf_hz": 1e9,
    }
    found = battery(respond(continuous_loop("mc_ppc", False, without)))
    falling = found.crossovers_hz[found.falling]
    np.testing.assert_allclose(falling, [102.52, 170.94], atol=0.01)


def test_the_slow_sampled_poles_map_back_to_known_ones_in_s():
    z = poles(sampled_loop("mc_ppc", False, {}))
    s = np.log(z[np.abs(z) > 0.9]) / T_S
    for printed in (-250.7 + 168.1j, -127.3 + 844.5j, -875 + 420j):
        assert np.min(np.abs(s - printed)) < 0.6


def test_the_current_loop_is_a_lag_of_450_hz():
    ideal = respond(continuous_loop("mc_ppc", False, {}), F_HZ)
    lagging = respond(continuous_loop("mc_ppc", True, {}), F_HZ)
    np.testing.assert_allclose(lagging.L, ideal.L / (1 + 1j * F_HZ / 450), rtol=1e-9)


def test_parts_that_are_switched_off_are_no_part_of_the_loop():
    count = [
        len(poles(continuous_loop("mc_ppc", current, {}))) for current in (False, True)
    ]
    # four masses' states, five filter states, one integrator; then the lag
    assert count == [10, 11]


def test_a_heavier_table_moves_the_loop_unless_the_law_knows():
    radius = [
        np.max(np.abs(poles(sampled_loop("mc_ppc", False, changes))))
        for changes in ({}, {"plant.m_2": 1.5 * M_2}, {"controller.m_2": 1.5 * M_2})
    ]
    assert radius[0] != pytest.approx(radius[1], abs=1e-6)
    # the inversion is no part of the loop
    assert radius[0] == pytest.approx(radius[2], abs=1e-12)


def test_an_unknown_controller_or_parameter_is_refused():
    with pytest.raises(LookupError, match="there are mc_ppc, p_pi"):
        figures("pid")
    with pytest.raises(LookupError, match="no parameter 'm_3' in plant or controller"):
        figures("mc_ppc", m_3=1.0)
