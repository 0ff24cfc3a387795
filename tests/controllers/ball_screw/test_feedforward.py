"""Inversions and pre-filter against transfer functions written out directly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from controllers.ball_screw import (
    inertia_feedforward,
    model_inversion,
    position_p,
    rotary_command,
    state_feedback,
    velocity_pi,
)
from controllers.ball_screw._drive import TwoMass
from controllers.ball_screw.friction_feedforward import Input as FrictionInput
from controllers.ball_screw.friction_feedforward import State as FrictionState
from controllers.ball_screw.friction_feedforward import step as friction_step
from controllers.filters import prefilter
from fmus.model import Sampled
from plants.ball_screw._friction import Stribeck

T_s = 1 / 20_000


def responses(model: Sampled, p: object, x_r: np.ndarray) -> np.ndarray:
    """Run a model over a command; one row of outputs per tick."""
    extra = (model.prepare(p, T_s),) if model.prepare else ()
    x, rows = model.state, []
    for x_k in x_r:
        u = model.input._replace(x_r=x_k)
        x, y = model.step(x, u, p, T_s, *extra)
        rows.append(np.array([*y]))
    return np.array(rows)


IMPULSE = np.eye(1, 40)[0]


def test_rotary_command_has_the_studys_coefficients() -> None:
    p = rotary_command.Parameters()
    found = responses(rotary_command.model, p, IMPULSE)[:, 0]
    b, pole = [381.285048, -761.338859, 380.581478], 0.4723328135
    assert found == pytest.approx(signal.lfilter(b, [1, -pole], IMPULSE), abs=2e-6)


def test_model_inversion_has_the_studys_coefficients() -> None:
    found = responses(model_inversion.model, model_inversion.Parameters(), IMPULSE)
    b = [
        283434979.078,
        -1132630399.074,
        1697753509.851,
        -1131355728.028,
        282797638.173,
    ]
    expected = signal.lfilter(b, [1, -0.4723328135], IMPULSE)
    assert found[:, 0] == pytest.approx(expected, rel=1e-9, abs=0.2)


def test_rotary_command_of_a_constant_is_the_constant_bit_by_bit() -> None:
    found = responses(rotary_command.model, rotary_command.Parameters(), np.ones(400))
    assert found[-1, 0] == 1.0


def drives() -> st.SearchStrategy[TwoMass]:
    return st.builds(
        TwoMass,
        m_1=st.floats(1e-4, 1e-2),
        m_2=st.floats(1e-4, 1e-2),
        b_1=st.sampled_from([0.0, 1e-6, 1.02e-3, 0.01]),
        b_2=st.sampled_from([0.0, 2e-3]),
        k=st.floats(20, 2000),
        c=st.sampled_from([0.0, 1e-4, 0.014, 0.1]),
    )


@given(drives())
def test_model_inversion_asks_for_inertia_and_friction_on_a_slow_command(
    p: TwoMass,
) -> None:
    t = T_s * np.arange(1500)
    drive = model_inversion.Parameters(p)
    u_ff = responses(model_inversion.model, drive, 50 * t * t)[-1, 0]
    # of x = a t²/2: mass times a, friction times v, three delays and the pole's
    b, m = p.b_1 + p.b_2, p.m_1 + p.m_2
    v_late = 100 * (t[-1] - 5 * T_s), 100 * t[-1]
    low, high = (m * 100 + b * v for v in v_late)
    slack = 0.01 * high + b * p.c / p.k * 100
    assert low - slack <= u_ff <= high + slack


@given(drives())
def test_model_inversion_zeros_are_the_plants_poles(
    p: TwoMass,
) -> None:
    r, q_1, q_0 = model_inversion.roots(p)
    a_1, a_2, a_3 = model_inversion.denominator(p)
    cubic = np.array([p.m_1 * p.m_2, a_1, a_2, a_3]) / (p.m_1 * p.m_2)
    assert np.convolve([1, r], [1, q_1, q_0]) == pytest.approx(cubic, rel=1e-12)


def test_switched_off_feedforward_is_silent() -> None:
    x_r = np.linspace(0, 1, 20) ** 2
    p = model_inversion.Parameters(on=False)
    assert not responses(model_inversion.model, p, x_r).any()
    q = inertia_feedforward.Parameters(on=False)
    assert not responses(inertia_feedforward.model, q, x_r).any()
    r = rotary_command.Parameters(on=False)
    assert np.array_equal(responses(rotary_command.model, r, x_r)[:, 0], x_r)


def test_analytic_variants_add_up_the_given_derivatives() -> None:
    inversion = model_inversion.Parameters(analytic=True)
    u = model_inversion.Input(0.0, 2.0, 3.0, 5.0, 7.0)
    d = model_inversion.prepare(inversion, T_s)
    x = model_inversion.State()
    for _ in range(100):
        x, y = model_inversion.step(x, u, inversion, T_s, d)
    p = inversion.drive
    a_1, a_2, a_3 = model_inversion.denominator(p)
    expected = (p.m_1 * p.m_2 * 7 + a_1 * 5 + a_2 * 3 + a_3 * 2) / p.k
    assert y.u_ff == pytest.approx(expected, rel=1e-12)

    rotary = rotary_command.Parameters(analytic=True, b_2=0.01)
    d_rotary = rotary_command.prepare(rotary, T_s)
    x_rotary = rotary_command.State()
    for _ in range(100):
        x_rotary, y_rotary = rotary_command.step(
            x_rotary, rotary_command.Input(1.0, 2.0, 3.0), rotary, T_s, d_rotary
        )
    expected = 1 + (rotary.m_2 * 3 + 0.01 * 2) / rotary.k
    assert y_rotary.x_1r == pytest.approx(expected, rel=1e-12)


@given(st.lists(st.floats(-100, 100), min_size=1, max_size=20))
def test_prefilter_without_gains_returns_the_command_bit_by_bit(
    x_r: list[float],
) -> None:
    found = responses(prefilter.model, prefilter.Parameters(), np.array(x_r))
    assert np.array_equal(found[:, 0], x_r)


def test_prefilter_regressors_are_the_matched_chain() -> None:
    x_r = np.random.default_rng(5).normal(size=200)
    found = responses(prefilter.model, prefilter.Parameters(K_acc=2.0), x_r)
    p = np.exp(-2 * np.pi * 80 * T_s)
    y = x_r
    for column in range(1, 5):
        y = signal.lfilter((1 - p) / T_s * np.array([1, -1]), [1, -p], y)
        last = signal.lfilter((1 - p) / 2 * np.array([1, 1]), [1, -p], y)
        scale = np.abs(last).max()
        assert found[:, column] == pytest.approx(last, abs=1e-10 * scale)
    assert found[:, 0] == pytest.approx(x_r + 2.0 * found[:, 2], rel=1e-12)


def test_inertia_feedforward_takes_backward_differences() -> None:
    p = inertia_feedforward.Parameters()
    t = T_s * np.arange(10)
    u_ff = responses(inertia_feedforward.model, p, 3 * t * t)[2:, 0]
    m_1, m_2, b_1, b_2 = p.drive
    expected = (m_1 + m_2) * 6 + (b_1 + b_2) * 6 * (t[2:] - T_s / 2)
    assert u_ff == pytest.approx(expected, rel=1e-6)


def test_state_feedback_weighs_errors_their_differences_and_the_sum() -> None:
    p = state_feedback.Parameters(2.0, 3.0, 5.0, 7.0, 11.0)
    x, y = state_feedback.step(
        state_feedback.State(0.1, 0.2, 0.3),
        state_feedback.Input(1, 2, 0.5, 0.5),
        p,
        0.1,
    )
    assert x == pytest.approx((0.5, 1.5, 0.45))
    expected = 2 * 0.5 + 3 * 1.5 + 5 * 0.4 / 0.1 + 7 * 1.3 / 0.1 + 11 * 0.45
    assert y.v == pytest.approx(expected)


def test_cascade_adds_the_command_velocity_and_sums_after_it() -> None:
    _, y = position_p.step(
        position_p.State(),
        position_p.Input(1.2, 0.9),
        position_p.Parameters(10),
        0.1,
    )
    assert y.v_c == pytest.approx(10 * 0.3)
    p = velocity_pi.Parameters(K_pv=2.0, K_iv=3.0)
    v_x, v_y = velocity_pi.step(
        velocity_pi.State(1.0, 0.5, 0.25), velocity_pi.Input(y.v_c, 1.2, 0.6), p, 0.1
    )
    assert v_x == pytest.approx((1.2, 0.6, 0.25 + 0.1 * 4))
    assert v_y.v == pytest.approx(2 * 4 + 3 * 0.65)


def test_friction_feedforward_follows_the_commanded_direction() -> None:
    p = Stribeck(on=True)
    for v, u_f in ((100.0, 0.12), (0.0, 0.0), (-100.0, -0.12)):
        _, y = friction_step(FrictionState(), FrictionInput(v), p, T_s)
        assert y.u_f == pytest.approx(u_f, abs=1e-12)
