"""Pole placement against the printed gains and the polynomial equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.synthesis.ball_screw import pole_placement
from controllers.synthesis.pole_placement import closed_loop_poles

DRIVE = {
    "m_1": 1.858e-3,
    "m_2": 0.379e-3,
    "b_1": 1.020e-3,
    "b_2": 0.0,
    "k": 210.02,
    "c": 0.014,
}


def gains_by_equating_coefficients(m_1, m_2, b_1, b_2, k, c, poles):
    """Solve the 5x5 system: s den(s) + feedback = m_1 m_2 Π(s - p_i)."""
    a_1 = m_1 * b_2 + m_2 * b_1 + (m_1 + m_2) * c
    a_2 = b_1 * b_2 + (b_1 + b_2) * c + (m_1 + m_2) * k
    a_3 = (b_1 + b_2) * k
    _, d_4, d_3, d_2, d_1, d_0 = m_1 * m_2 * np.real(np.poly(poles))
    e = c + b_2
    equations = [
        [0, 0, m_2, 0, 0],
        [m_2, 0, e, c, 0],
        [e, c, k, k, 0],
        [k, k, 0, 0, c],
        [0, 0, 0, 0, k],
    ]
    return np.linalg.solve(equations, [d_4 - a_1, d_3 - a_2, d_2 - a_3, d_1, d_0])


def test_gains_are_the_printed_ones():
    gains = pole_placement.design(**DRIVE)
    printed = {
        "K_x1": 632.965300,
        "K_x2": -83.312458,
        "K_v1": 1.648469979,
        "K_v2": 0.264903101,
        "K_i2": 70135.3877,
    }
    assert list(gains) == list(printed)
    for name, value in printed.items():
        assert gains[name] == pytest.approx(value, rel=1e-8)


def test_wanted_poles_are_the_printed_ones():
    A, _ = pole_placement.augmented(**DRIVE)
    poles = closed_loop_poles(np.linalg.eigvals(A), 4.0, 50.0, 0.7)
    printed = [-89.13461 + 816.50560j, -219.91149 + 224.35459j, -314.15927]
    np.testing.assert_allclose(poles[[0, 1, 4]], printed, atol=6e-6)


@settings(max_examples=30, deadline=None)
@given(
    scale=st.tuples(*[st.floats(0.5, 2.0)] * 6),
    beta=st.floats(1.5, 6.0),
    f2_hz=st.floats(20.0, 80.0),
)
def test_gains_solve_the_polynomial_equations_for_any_drive(scale, beta, f2_hz):
    start = DRIVE | {"b_2": 1e-3}
    drive = {name: start[name] * by for name, by in zip(start, scale, strict=True)}
    A, B = pole_placement.augmented(**drive)
    poles = closed_loop_poles(np.linalg.eigvals(A), beta, f2_hz, 0.7)
    expected = gains_by_equating_coefficients(**drive, poles=poles)
    gains = np.array(
        list(pole_placement.design(**drive, beta=beta, f2_hz=f2_hz).values())
    )
    size = np.abs(expected).max()
    np.testing.assert_allclose(gains, expected, rtol=1e-7, atol=1e-12 * size)
    closed = np.sort_complex(np.linalg.eigvals(A - B @ gains[None, :]))
    np.testing.assert_allclose(closed, np.sort_complex(poles), rtol=1e-6)


def test_a_drive_without_oscillation_is_refused():
    with pytest.raises(ValueError, match="no oscillating axial mode"):
        pole_placement.design(**DRIVE | {"c": 10.0})
