"""Cascades P/PI and NP/PI: the nonlinear gain, its parts, what KO = 0 means."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.xy_table import gain_ramp, np_pi, speed_pi, velocity_estimator
from controllers.xy_table import p_pi as p_pi_cascade
from controllers.xy_table import position_np as np_position
from controllers.xy_table._cascade import Input

T_s = 1 / 2000
SIGNALS = st.lists(
    st.tuples(*[st.floats(-1, 1) for _ in range(3)], st.floats(0.5, 3)), max_size=30
)
ESTIMATORS = [
    velocity_estimator.Parameters(measured, filtered, 300.0)
    for measured in (False, True)
    for filtered in (False, True)
]


def outputs(module: Any, p: Any, signals: list[tuple[float, ...]]) -> np.ndarray:
    """Return u, e, v_ref of a whole cascade, shape (n, 3)."""
    x, d = module.model.state, module.prepare(p, T_s)
    rows = []
    for signal in signals:
        x, y = module.step(x, Input(*signal), p, T_s, d)
        rows.append(tuple(y))
    return np.array(rows).reshape(-1, 3)


def test_the_gain_is_that_of_table_1() -> None:
    assert np_position.nonlinear_gain(0.2, 3.5, 0.5) == pytest.approx(1.25517, abs=5e-6)
    assert np_position.nonlinear_gain(0.5, 3.5, 0.5) == pytest.approx(2.9642, abs=5e-5)
    assert np_position.nonlinear_gain(0.5, 4.0, 0.5) == pytest.approx(3.7622, abs=5e-5)


@given(st.floats(-5, 5))
def test_the_gain_is_even_at_least_one_and_held_beyond_e_max(e: float) -> None:
    N = np_position.nonlinear_gain(e, 3.5, 0.5)
    assert np_position.nonlinear_gain(-e, 3.5, 0.5) == N
    assert 1 <= N <= np.cosh(1.75)
    if abs(e) >= 0.5:
        assert np.cosh(1.75) == N


@given(SIGNALS, st.sampled_from(ESTIMATORS))
def test_without_variation_np_pi_is_p_pi_to_the_last_bit(
    signals: list[tuple[float, ...]], estimator: velocity_estimator.Parameters
) -> None:
    nonlinear = outputs(np_pi, np_pi.Parameters(KO=0.0, estimator=estimator), signals)
    plain = outputs(p_pi_cascade, p_pi_cascade.Parameters(estimator=estimator), signals)
    np.testing.assert_array_equal(nonlinear, plain)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_cascade_is_its_parts_one_after_the_other(
    estimator: velocity_estimator.Parameters,
) -> None:
    rng = np.random.default_rng(5)
    signals = [tuple(row) for row in rng.normal(size=(40, 4))]
    p = np_pi.Parameters(200.0, 3.0, 0.4, 0.007, 0.13, estimator)
    d = velocity_estimator.prepare(estimator, T_s)
    x_v, x_s = velocity_estimator.State(), speed_pi.State()
    rows = []
    for z_ref, y, v, g in signals:
        _, position = np_position.step(
            np_position.State(),
            np_position.Input(z_ref, y, g),
            np_position.Parameters(p.k_v, p.KO, p.e_max),
            T_s,
        )
        x_v, estimate = velocity_estimator.step(
            x_v, velocity_estimator.Input(y, v), estimator, T_s, d
        )
        x_s, speed = speed_pi.step(
            x_s,
            speed_pi.Input(position.v_ref, estimate.v_est),
            speed_pi.Parameters(p.k_p, p.k_i),
            T_s,
        )
        rows.append((speed.u, position.e, position.v_ref))
    np.testing.assert_array_equal(outputs(np_pi, p, signals), rows)


@pytest.mark.parametrize("p", ESTIMATORS)
def test_every_estimator_finds_a_steady_velocity(
    p: velocity_estimator.Parameters,
) -> None:
    x, d = velocity_estimator.State(), velocity_estimator.prepare(p, T_s)
    for k in range(200):
        u = velocity_estimator.Input(y=3.0 * k * T_s, v=3.0)
        x, y = velocity_estimator.step(x, u, p, T_s, d)
    assert y.v_est == pytest.approx(3.0, rel=1e-9)


def test_the_filter_lets_go_of_a_jump_with_its_time_constant() -> None:
    p = velocity_estimator.Parameters(measured=True, filtered=True, omega_c_hz=20.0)
    d = velocity_estimator.prepare(p, T_s)
    x, found = velocity_estimator.State(), []
    for k in range(400):
        u = velocity_estimator.Input(v=float(k == 0))
        x, y = velocity_estimator.step(x, u, p, T_s, d)
        found.append(y.v_est)
    ratios = np.array(found[2:]) / np.array(found[1:-1])
    np.testing.assert_allclose(ratios, np.exp(-2 * np.pi * 20 * T_s), rtol=1e-12)
    assert sum(found) == pytest.approx(1.0, rel=1e-5)


def test_the_ramp_rests_then_rises_without_drift() -> None:
    p = gain_ramp.Parameters(g_0=2.0, r=0.2, t_0=0.5)
    for k in (0, 1000, 1001, 4_000_000):
        _, y = gain_ramp.step(gain_ramp.State(float(k)), gain_ramp.Input(), p, T_s)
        assert y.g == pytest.approx(2 + 0.2 * max(k / 2000 - 0.5, 0), rel=1e-15)
