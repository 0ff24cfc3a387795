"""Pre-filter identification recovers what an error was made of."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from controllers.synthesis.matched import coefficients, factored, matched
from controllers.synthesis.prefilter import identify, regressors

T_S = 5e-5


def smooth_move():
    """Return a 15 ms move of 3 rad between rests (rad), five times smoothed."""
    x_r = np.where(np.arange(1500) > 100, 3.0, 0.0)
    for _ in range(5):
        x_r = signal.lfilter(np.full(60, 1 / 60), [1], x_r)
    return x_r


def test_regressors_are_the_matched_low_passed_derivatives():
    x_r = smooth_move()
    w = 2 * np.pi * 80
    H = coefficients(matched(factored([w], [1, w]), T_S))
    D = coefficients(matched(factored([w, 0], [1, w]), T_S))
    phi = regressors(x_r, T_S, 80.0)
    rate = x_r
    for column in phi.T:
        rate = signal.lfilter(*D, rate)
        expected = signal.lfilter(*H, rate)
        np.testing.assert_allclose(column, expected, atol=1e-7 * abs(expected).max())


gains = st.tuples(
    st.floats(-1e-5, 1e-5),
    st.floats(-1e-6, 1e-6),
    st.floats(-1e-9, 1e-9),
    st.floats(-1e-11, 1e-11),
)


@settings(max_examples=20, deadline=None)
@given(gains)
def test_identification_recovers_gains_of_very_different_size(K):
    x_r = smooth_move()
    phi = regressors(x_r, T_S, 80.0)
    e_2 = phi @ K
    found = identify(x_r, x_r - e_2, T_S)
    assert list(found) == ["K_vel", "K_acc", "K_jerk", "K_snap"]
    norms = np.linalg.norm(phi, axis=0)
    np.testing.assert_allclose(
        np.array(list(found.values())) * norms,
        np.array(K) * norms,
        atol=1e-9 * np.abs(e_2).max() + 1e-12,  # x_r - y_2 rounds
    )


def test_signals_of_different_length_are_refused():
    with pytest.raises(ValueError, match="same instants"):
        identify(np.zeros(5), np.zeros(4), T_S)


def test_a_command_at_rest_is_refused():
    with pytest.raises(ValueError, match="does not move"):
        identify(np.zeros(50), np.zeros(50), T_S)
