"""Run-time controllers of the gantry against the source's formulas in the s-domain."""

import numpy as np
import pytest

from controllers.filters import linear_prefilter, prefilter
from controllers.filters._sections import low_pass
from controllers.gantry import averaging as gantry_averaging
from controllers.gantry import double_lead
from controllers.gantry import filters as gantry_filters
from controllers.gantry import mimo as gantry_mimo
from controllers.gantry import pid as gantry_pid
from controllers.gantry import prefilter as gantry_prefilter
from controllers.gantry import schedule as gantry_schedule
from controllers.gantry import x as gantry_x
from controllers.gantry import x_filters as gantry_x_filters
from controllers.gantry._common import Input
from controllers.synthesis.gantry.continuous import mimo_law, pid_law, x_law
from controllers.synthesis.linearise import linearise
from plants.gantry import frame as gantry

T_s = 1 / 15_000
F_HZ = np.array([1.0, 10.0, 40.0, 94.0])


def sampled(model, inputs, outputs, **values):
    z = np.exp(2j * np.pi * F_HZ * T_s)
    system = linearise(model, inputs=inputs, outputs=outputs, **values)
    return np.moveaxis(system.horner(z), -1, 0)


def test_matched_sections_have_the_coefficients_of_an_independent_computation():
    h = gantry_filters.prepare(gantry_filters.Parameters(), T_s)
    assert h.notch_1[:3] == pytest.approx((0.99091114, -1.9351446, 0.94628914))
    assert h.notch_1[3:] == pytest.approx((-1.9354735, 0.93752921))
    assert h.lpf == pytest.approx(
        (0.007774224, 0.015548448, 0.007774224, -1.7349032, 0.7660001), rel=1e-6
    )
    assert h.lead == pytest.approx((27.08995, -26.783564, 0.69361414))
    lpf = gantry_x_filters.prepare(gantry_x_filters.Parameters(), T_s).lpf
    assert (lpf.gain / 2, lpf.p) == pytest.approx((0.19753872, 0.60492256))
    smooth = low_pass(2 * np.pi * 80, T_s)
    assert (smooth.gain / 2, smooth.p) == pytest.approx((0.016477535, 0.96704493))
    p = gantry_averaging.Parameters()
    D = gantry_averaging.prepare(p, T_s)
    assert (p.K * D.b_0, p.K * D.b_1, D.p) == pytest.approx(
        (360669.93, -355600.5, 0.95635778)
    )
    x = double_lead.prepare(double_lead.Parameters(), T_s)
    assert x.lead == pytest.approx((15.62449, -15.421555, 0.79706554))
    K = double_lead.Parameters().K
    assert (K * (x.T_p + T_s), K * x.T_p) == pytest.approx(
        (44268.527, 43845.506), rel=1e-5
    )


def test_the_x_controller_is_its_transfer_function_at_low_frequencies():
    law = -sampled(gantry_x.model, ["x_m"], ["u"])[:, 0, 0]
    expected = x_law(gantry_x.Parameters(), 2j * np.pi * F_HZ)
    # matched poles and zeros: phase and gain part with frequency over sampling rate
    assert np.abs(law / expected - 1) == pytest.approx(0, abs=5e-3)


@pytest.mark.parametrize("x", [-0.15, 0.0, 0.15])
@pytest.mark.parametrize(
    ("model", "law"), [(gantry_mimo.model, mimo_law), (gantry_pid.model, pid_law)]
)
def test_the_y_controllers_are_their_transfer_matrices(model, law, x):
    K = -sampled(model, ["y_1m", "y_2m"], ["u_1", "u_2"], input=Input(x_s=x))
    expected = law(model.parameters, x, 2j * np.pi * F_HZ)
    # a backward difference lags by half a sample
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    assert np.abs(K - expected) / size == pytest.approx(0, abs=0.025)


@pytest.mark.parametrize("x", [-0.15, 0.0, 0.1])
def test_feedforward_makes_the_gantry_follow_without_yaw(x):
    model = gantry_mimo.model
    command = Input(a_yr=1.0, x_s=x)
    derived = gantry_mimo.prepare(model.parameters, T_s)
    _, u = model.step(model.state, command, model.parameters, T_s, derived)
    slope = gantry.derivative(
        gantry.State(), gantry.Input(u.u_1, u.u_2, 0.0, x), gantry.Parameters()
    )
    assert (slope.v_1, slope.v_2) == pytest.approx((1.0, 1.0))


def test_the_schedule_is_the_plants_own_geometry():
    for x in (-0.15, 0.0, 0.15):
        _, now = gantry_schedule.step(
            gantry_schedule.State(),
            gantry_schedule.Input(x),
            gantry_schedule.Parameters(),
            T_s,
        )
        g = gantry.geometry(x, gantry.Parameters())
        assert now.alpha_1 == pytest.approx(g.a_2 / 1.484)
        assert now.alpha_2 == pytest.approx(g.a_1 / 1.484)
    assert (now.m_11, now.m_12, now.m_22) == pytest.approx(
        (1.07328, 0.442950, 0.762816), rel=1e-5
    )


def test_without_damping_and_integral_equal_errors_give_forces_in_proportion_to_mass():
    p = gantry_averaging.Parameters(beta=0.0, k_i=0.0)
    u = gantry_averaging.Input(1e-6, 1e-6, 0.0, 0.0, 0.6, 0.4)
    d = gantry_averaging.prepare(p, T_s)
    _, y = gantry_averaging.step(gantry_averaging.State(), u, p, T_s, d)
    assert y.v_1 / y.v_2 == pytest.approx(1.5)


def test_prefilters_in_metres_are_the_one_in_radians():
    p = prefilter.Parameters(1e-9, -2e-9, 3e-10, 4e-11)
    ends = gantry_prefilter.Parameters(*p[:4], *(2 * K for K in p[:4]))
    section = prefilter.prepare(p, T_s)
    a, b, c = prefilter.State(), linear_prefilter.State(), linear_prefilter.State()
    for k in range(50):
        r = 1e-3 * np.sin(0.1 * k)
        a, rad = prefilter.step(a, prefilter.Input(r), p, T_s, section)
        b, metre = linear_prefilter.step(b, linear_prefilter.Input(r), p, T_s, section)
        c, two = gantry_prefilter.step(c, gantry_prefilter.Input(r), ends, T_s, section)
        assert metre == rad
        assert (two.y_1f, two.v_f, two.s_f) == (rad.x_f, rad.v_f, rad.s_f)
        assert two.y_2f - r == pytest.approx(2 * (rad.x_f - r), abs=1e-18)
