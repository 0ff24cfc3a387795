"""Matched discretisation against coefficients computed independently."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.ball_screw import filter_pack, model_inversion, rotary_command
from controllers.ball_screw._drive import TwoMass
from controllers.synthesis.linearise import linearise
from controllers.synthesis.matched import Factored, coefficients, factored, matched

T_S = 5e-5
M_1, M_2, B_1, B_2, K, C = 1.858e-3, 0.379e-3, 1.020e-3, 0.0, 210.02, 0.014


def notch(f_hz, zeta_z, zeta_p):
    w = 2 * np.pi * f_hz
    return factored([1, 2 * zeta_z * w, w**2], [1, 2 * zeta_p * w, w**2])


def low_pass(f_hz):
    w = 2 * np.pi * f_hz
    return factored([w], [1, w])


@pytest.mark.parametrize(
    ("section", "numerator", "denominator"),
    [
        (
            notch(420, 0.55, 0.7),
            [0.98093615, -1.81347415, 0.84841151],
            [1, -1.81545881, 0.83133233],
        ),
        (
            notch(1080, 0.05, 0.7),
            [0.80963792, -1.50150071, 0.78262835],
            [1, -1.53111402, 0.62187958],
        ),
        (low_pass(2000), [0.23325595, 0.23325595], [1, -0.53348809]),
    ],
)
def test_filter_pack_sections_are_the_printed_ones(section, numerator, denominator):
    b, a = coefficients(matched(section, T_S))
    np.testing.assert_allclose(b, numerator, atol=6e-9)
    np.testing.assert_allclose(a, denominator, atol=6e-9)


def test_rotary_command_is_the_printed_one():
    b, a = coefficients(matched(factored([M_2, B_2 + C, K], [C, K]), T_S))
    np.testing.assert_allclose(b, [381.285048, -761.338859, 380.581478], atol=6e-7)
    np.testing.assert_allclose(a, [1, -0.4723328135], atol=6e-11)


def test_model_inversion_is_the_printed_one():
    a_1 = M_1 * B_2 + M_2 * B_1 + (M_1 + M_2) * C
    a_2 = B_1 * B_2 + (B_1 + B_2) * C + (M_1 + M_2) * K
    a_3 = (B_1 + B_2) * K
    G_ff = matched(factored([M_1 * M_2, a_1, a_2, a_3, 0], [C, K]), T_S)
    b, _ = coefficients(G_ff)
    printed = [
        283434979.078,
        -1132630399.074,
        1697753509.851,
        -1131355728.028,
        282797638.173,
    ]
    np.testing.assert_allclose(b, printed, atol=2e-3)


def response_of(G, T_s, z):
    """Return G matched and made causal, at points z."""
    H = matched(G, T_s)
    value = H.gain * np.prod(z[:, None] - H.zeros, axis=1)
    value = value / np.prod(z[:, None] - H.poles, axis=1)
    return value * z ** -max(0, len(H.zeros) - len(H.poles))


notches = st.tuples(st.floats(100, 1500), st.floats(0.02, 0.95), st.floats(0.02, 0.95))


@settings(max_examples=15, deadline=None)
@given(notches, notches, st.floats(300, 3000), st.floats(2e-5, 2e-4))
def test_the_run_time_filter_pack_is_the_matched_one(first, second, f_lpf, T_s):
    p = filter_pack.Parameters(
        omega_lpf_hz=f_lpf,
        omega_n1_hz=first[0],
        zeta_z1=first[1],
        zeta_p1=first[2],
        omega_n2_hz=second[0],
        zeta_z2=second[1],
        zeta_p2=second[2],
    )
    run_time = linearise(filter_pack.model, parameters=p, inputs=["v"], T_s=T_s)
    z = np.exp(2j * np.pi * np.array([0.001, 0.01, 0.1, 0.3, 0.45]))
    expected = response_of(low_pass(f_lpf), T_s, z)
    for values in (first, second):
        expected = expected * response_of(notch(*values), T_s, z)
    np.testing.assert_allclose(run_time(z), expected, rtol=1e-9)


@pytest.mark.parametrize("T_s", [2.5e-5, T_S, 1e-4])
@pytest.mark.parametrize("b_2", [0.0, 2e-3])
def test_the_run_time_command_generators_are_the_matched_ones(b_2, T_s):
    drive = {"m_2": M_2, "b_2": b_2, "k": K, "c": C}
    z = np.exp(2j * np.pi * np.array([0.001, 0.01, 0.1, 0.3, 0.45]))
    G_r = factored([M_2, b_2 + C, K], [C, K])
    run_time = linearise(
        rotary_command.model,
        parameters=rotary_command.Parameters(**drive),
        inputs=["x_r"],
        T_s=T_s,
    )
    np.testing.assert_allclose(run_time(z), response_of(G_r, T_s, z), rtol=1e-9)

    a_1 = M_1 * b_2 + M_2 * B_1 + (M_1 + M_2) * C
    a_2 = B_1 * b_2 + (B_1 + b_2) * C + (M_1 + M_2) * K
    G_ff = factored([M_1 * M_2, a_1, a_2, (B_1 + b_2) * K, 0], [C, K])
    drive |= {"m_1": M_1, "b_1": B_1}
    run_time = linearise(
        model_inversion.model,
        parameters=model_inversion.Parameters(TwoMass(**drive)),
        inputs=["x_r"],
        T_s=T_s,
    )
    np.testing.assert_allclose(run_time(z), response_of(G_ff, T_s, z), rtol=1e-7)


def test_leaving_out_infinite_zeros_gives_the_low_pass_with_a_whole_delay():
    b, a = coefficients(matched(low_pass(2000), T_S, infinite_zeros=False))
    p = np.exp(-2 * np.pi * 2000 * T_S)
    np.testing.assert_allclose(b, [1 - p], rtol=1e-14)
    np.testing.assert_allclose(a, [1, -p], rtol=1e-14)


roots = st.lists(st.floats(-3000, -0.01), max_size=4)


@settings(deadline=None)
@given(roots, roots, st.integers(-2, 2), st.floats(0.1, 10))
def test_slow_signals_pass_as_through_the_transfer_function(zeros, poles, n, gain):
    zeros, poles = zeros + [0.0] * max(0, n), poles + [0.0] * max(0, -n)
    G = Factored(np.array(zeros, complex), np.array(poles, complex), gain)
    H = matched(G, T_S)

    def at(point, system):
        return (
            system.gain * np.prod(point - system.zeros) / np.prod(point - system.poles)
        )

    for omega in (1e-5, 1e-6):
        s = 1j * omega
        ratio = at(np.exp(s * T_S), H) / at(s, G)
        assert abs(ratio - 1) < 1e-4
    assert len(H.zeros) == max(len(zeros), len(poles))
    assert len(H.poles) == len(poles)
