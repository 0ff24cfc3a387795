"""Matched sections against exp(s T_s) of the roots and the study's coefficients."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from controllers.ball_screw import filter_pack
from controllers.filters._sections import (
    decay,
    filtered,
    low_pass,
    notch,
    pair,
    smoothed,
)

T_s = 1 / 20_000
frequency_hz = st.floats(0.1, 5000)
damping = st.floats(0.0, 3.0)


@given(frequency_hz, damping)
def test_a_pair_in_differences_is_the_product_of_its_matched_roots(
    f_hz: float, zeta: float
) -> None:
    omega = 2 * np.pi * f_hz
    found = pair(2 * zeta * omega, omega**2, T_s)
    roots = omega * (-zeta + np.array([1, -1]) * np.emath.sqrt(zeta**2 - 1))
    expected = np.real(np.poly(np.exp(roots * T_s)))
    in_powers = [1, found.alpha - 2, 1 - found.alpha + found.beta]
    assert in_powers == pytest.approx(expected, rel=1e-9, abs=1e-12)


@given(st.floats(1e-4, 1.0), st.floats(0.1, 0.9))
def test_a_slow_pair_keeps_its_digits(f_hz: float, zeta: float) -> None:
    omega_T = 2 * np.pi * f_hz * T_s
    found = pair(2 * zeta * omega_T / T_s, (omega_T / T_s) ** 2, T_s)
    # (ωT)² to first order; the sum of plain coefficients would have lost it
    assert found.beta == pytest.approx(omega_T**2, rel=2 * omega_T + 1e-12)


@given(st.floats(1e-9, 1e6))
def test_one_minus_a_decay_keeps_its_digits(pole: float) -> None:
    p, missing = decay(pole, T_s)
    assert p + missing == pytest.approx(1.0, abs=2e-16)
    assert missing == -np.expm1(-pole * T_s)


@pytest.mark.parametrize(
    ("omega_hz", "zeta_z", "zeta_p", "coefficients"),
    [
        (
            420,
            0.55,
            0.7,
            (0.98093615, -1.81347415, 0.84841151, -1.81545881, 0.83133233),
        ),
        (
            1080,
            0.05,
            0.7,
            (0.80963792, -1.5015007, 0.78262835, -1.53111402, 0.62187958),
        ),
    ],
)
def test_notches_have_the_studys_coefficients(
    omega_hz: float, zeta_z: float, zeta_p: float, coefficients: tuple[float, ...]
) -> None:
    found = notch(omega_hz, zeta_z, zeta_p, T_s)
    assert tuple(found) == pytest.approx(coefficients, abs=1e-8)


def test_low_pass_has_the_studys_coefficients() -> None:
    found = low_pass(2 * np.pi * 2000, T_s)
    assert found.p == pytest.approx(0.53348809, abs=1e-8)
    assert found.gain / 2 == pytest.approx(0.23325595, abs=1e-8)


def test_sections_filter_as_scipy_does() -> None:
    x = np.random.default_rng(3).normal(size=300)
    s, lpf = notch(420.0, 0.55, 0.7, T_s), low_pass(500.0, T_s)
    w_1 = w_2 = w = 0.0
    through_notch, through_low_pass = [], []
    for x_k in x:
        w_1, w_2, y = filtered(w_1, w_2, x_k, s)
        through_notch.append(y)
        w, y = smoothed(w, x_k, lpf)
        through_low_pass.append(y)
    expected = signal.lfilter([s.b_0, s.b_1, s.b_2], [1, s.a_1, s.a_2], x)
    assert through_notch == pytest.approx(expected, abs=1e-12)
    half = lpf.gain / 2
    expected = signal.lfilter([half, half], [1, -lpf.p], x)
    assert through_low_pass == pytest.approx(expected, abs=1e-13)


def test_filter_pack_passes_a_constant_and_adds_feedforward_unfiltered() -> None:
    p, x = filter_pack.Parameters(), filter_pack.State()
    d = filter_pack.prepare(p, T_s)
    first = filter_pack.step(x, filter_pack.Input(0.0, 2.0, 0.5), p, T_s, d)[1]
    assert first.u == 2.5
    for _ in range(400):
        x, y = filter_pack.step(x, filter_pack.Input(1.0, 2.0, 0.5), p, T_s, d)
    assert y.u == pytest.approx(3.5, abs=1e-12)


def test_filter_pack_is_the_matched_transfer_function() -> None:
    p = filter_pack.Parameters()
    d = filter_pack.prepare(p, T_s)
    x, impulse = filter_pack.State(), []
    for k in range(2000):
        x, y = filter_pack.step(x, filter_pack.Input(float(k == 0)), p, T_s, d)
        impulse.append(y.u)

    def roots(*zeta: float) -> np.ndarray:
        pairs = zip(zeta, 2 * np.pi * np.array([420.0, 1080.0]), strict=True)
        return np.concatenate([np.roots([1, 2 * z * w, w * w]) for z, w in pairs])

    zeros = np.append(np.exp(roots(0.55, 0.05) * T_s), -1)
    poles = np.exp(np.append(roots(0.7, 0.7), -2 * np.pi * 2000) * T_s)
    gain = np.real(np.prod(1 - poles) / np.prod(1 - zeros))
    omega_T = 2 * np.pi * np.array([0.0, 10, 130, 420, 1080, 4000, 9000]) * T_s
    _, expected = signal.freqz_zpk(zeros, poles, gain, worN=omega_T)
    found = np.polyval(impulse[::-1], np.exp(-1j * omega_T))
    assert found == pytest.approx(expected, abs=1e-10)
