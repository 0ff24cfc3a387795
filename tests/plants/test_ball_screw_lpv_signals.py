"""Forces, masses and references of the ball screw with varying dynamics."""

import numpy as np
import pytest
from scipy.linalg import expm

from controllers.ball_screw_lpv import observer, pid, reference, supervisor
from plants.ball_screw_lpv import (
    encoder,
    harmonic,
    milling,
    motor_drive,
    run_out,
    workpiece,
)
from plants.ball_screw_lpv._mode import R_G

UP = milling.Parameters()
DOWN = milling.Parameters(phi_st=np.pi / 2, phi_ex=np.pi)


def sliced(phi: float, p: milling.Parameters, slices: int = 4000) -> np.ndarray:
    """Forces of all teeth by adding up slices of the helix."""
    z = (np.arange(slices) + 0.5) * p.depth / slices
    F = np.zeros(2)
    for j in range(4):
        angle = (phi + np.pi / 2 * j - 2 * np.tan(p.beta) / p.D * z) % (2 * np.pi)
        cutting = (p.phi_st <= angle) & (angle <= p.phi_ex)
        chip = p.c * np.sin(angle)
        F_t = np.where(cutting, p.K_te + p.K_tc * chip, 0.0) * p.depth / slices
        F_r = np.where(cutting, p.K_re + p.K_rc * chip, 0.0) * p.depth / slices
        F[0] += np.sum(-F_t * np.cos(angle) - F_r * np.sin(angle))
        F[1] += np.sum(F_t * np.sin(angle) - F_r * np.cos(angle))
    return F


@pytest.mark.parametrize("p", [UP, DOWN])
def test_the_cutting_force_is_the_sum_over_the_helix(p):
    for phi in np.linspace(0, 2 * np.pi, 29, endpoint=False):
        teeth = [
            milling.tooth((phi + np.pi / 2 * j) % (2 * np.pi), p) for j in range(4)
        ]
        assert np.sum(teeth, axis=0) == pytest.approx(sliced(phi, p), abs=0.2)


def forces(p: milling.Parameters, seconds: float) -> np.ndarray:
    T_s = float(milling.model.period)
    k = np.arange(round(seconds / T_s))
    return milling.step(milling.State(k), milling.Input(), p, T_s)[1]


@pytest.mark.parametrize(("p", "least"), [(UP, 152.2), (DOWN, 169.2)])
def test_the_cutting_force_has_the_extremes_of_the_source(p, least):
    F = forces(p, 0.5).F
    assert np.max(F) == pytest.approx(665.1, rel=5e-3)
    assert np.min(F) == pytest.approx(least, rel=5e-3)


def test_the_tooth_passes_at_1424_rad_per_second():
    F = forces(UP, 3.0).F  # 170 turns
    amplitude = np.abs(np.fft.rfft(F - np.mean(F)))
    found = 2 * np.pi * np.argmax(amplitude) / 3.0
    assert found == pytest.approx(1424.19, abs=1e-2)


def test_the_cutting_force_acts_against_the_motion_and_while_in_the_cut_alone():
    y = forces(UP._replace(t_on=0.1, t_off=0.2), 0.3)
    inside = (np.arange(y.f.size) * 6e-5 >= 0.1 - 1e-9) & (
        np.arange(y.f.size) * 6e-5 < 0.2 - 1e-9
    )
    assert np.array_equal(y.f, np.where(inside, -y.F, 0.0))


def test_the_harmonic_force_of_3_volts_is_602_newtons():
    p, T_s = harmonic.Parameters(t_0=0.03), 6e-5
    k = np.arange(2000)
    y = harmonic.step(harmonic.State(k), harmonic.Input(), p, T_s)[1]
    t = k * T_s - 0.03
    assert y.v == pytest.approx(np.where(t >= -1e-9, 3 * np.sin(1350 * t), 0.0))
    assert y.f == pytest.approx(0.72 * 0.887 / R_G * y.v)
    assert np.max(y.f) == pytest.approx(602, abs=0.5)


def test_the_workpiece_loses_mass_in_the_cut_alone_and_never_more_than_it_has():
    p = workpiece.Parameters(m_0=10, rate=20, t_on=0.1, t_off=0.3)
    k = np.array([0, 100, 200, 300, 400])

    def mass(p):
        state = workpiece.State(k)
        return workpiece.step(state, workpiece.Input(), p, 1e-3)[1].m_wor

    assert mass(p) == pytest.approx([10, 10, 8, 6, 6])
    assert mass(p._replace(rate=1000))[-1] == 0


def test_run_out_comes_once_per_turn_of_the_screw():
    p = run_out.Parameters(F=5.0, phase=0.3)
    for x_c in (0.25, 0.257):
        here, there = (
            run_out.step(run_out.State(), run_out.Input(x), p, 6e-5)[1].f
            for x in (x_c, x_c + 0.020)
        )
        assert here == pytest.approx(5 * np.sin(x_c / R_G + 0.3))
        assert there == pytest.approx(here)


def test_the_linear_encoder_reads_in_steps_of_100_nm():
    u = encoder.Input(0.20000004, 0.30000026)
    y = encoder.step(encoder.State(), u, encoder.Parameters(), 3.6e-4)[1]
    assert y.y_m == u.u_m
    assert y.y_c == pytest.approx(0.3000003, abs=1e-15)
    assert y.x_c == pytest.approx(0.65 - 0.3000003, abs=1e-15)


def test_the_reference_goes_out_and_back_within_its_limits():
    p, T_s = reference.Parameters(dwell=0.1), 1e-4
    assert reference.move_time(p) == pytest.approx(0.965)
    k = np.arange(23_000)
    y = reference.step(reference.State(k), reference.Input(), p, T_s)[1]
    assert y.r[0] == 0.15
    assert y.r[9_650] == pytest.approx(0.45, abs=1e-13)
    assert y.r[[20_300, -1]] == pytest.approx(0.15, abs=1e-13)
    assert np.max(np.abs(y.v_r)) == pytest.approx(0.48)
    assert np.max(np.abs(y.a_r)) == pytest.approx(2.0)
    assert np.max(np.abs(np.diff(y.a_r))) <= 20 * T_s * (1 + 1e-9)
    assert np.gradient(y.r, T_s)[1:-1] == pytest.approx(y.v_r[1:-1], abs=2e-6)
    assert np.gradient(y.v_r, T_s)[1:-1] == pytest.approx(y.a_r[1:-1], abs=2e-3)


def test_the_supervisor_holds_the_region_between_the_surfaces():
    p, x, seen = supervisor.Parameters(), supervisor.State(), []
    for x_c in (0.26, 0.269, 0.27, 0.26, 0.2501, 0.25, 0.26, 0.6):
        x, y = supervisor.step(x, supervisor.Input(x_c), p, 3.6e-4)
        seen.append(y.region)
    assert seen == [1, 1, 2, 2, 2, 1, 1, 2]


def test_the_pid_controller_has_its_gains_by_tustins_rule():
    p, T_s = pid.Parameters(), 3.6e-4
    x, response = pid.State(), []
    for k in range(400):
        x, y = pid.step(x, pid.Input(1e-6 * (k == 0), 0.0), p, T_s)
        response.append(y.v_m / 1e-6)
    z = np.exp(1j * 200 * T_s)
    s = 2 / T_s * (z - 1) / (z + 1)
    expected = 5e4 + 3e6 / s + 120 * s / (s / 400 + 1)
    got = np.sum(response * z ** -np.arange(400.0))
    # beyond the samples the integral keeps its value
    got += response[-1] * z**-400.0 / (1 - 1 / z)
    assert got == pytest.approx(expected, rel=1e-9)


def test_the_observer_finds_a_constant_force_on_the_rigid_drive():
    """d̂ tends to the volts of a load that v_m does not explain."""
    p, T_s = observer.Parameters(), 3.6e-4
    d = observer.prepare(p, T_s)
    k = p.k_t * p.k_a * p.r_g
    A = np.array([[0, 1], [0, -p.B_e / p.J_e]])
    B = np.array([0, k / p.J_e])
    whole = expm(T_s * np.block([[A, B[:, None]], [np.zeros((1, 3))]]))
    u, x = np.array([0.3, 0.0]), observer.State()
    for k in range(4000):
        v_m, load = 0.4 * np.sin(20 * k * T_s), 0.7
        x, y = observer.step(x, observer.Input(u[0], v_m), p, T_s, d)
        u = whole[:2, :2] @ u + whole[:2, 2] * (v_m + load)
    assert y.d == pytest.approx(0.7, abs=0.02)


def test_the_current_loop_has_the_published_gain_and_bandwidth():
    """G_1(0) = k_a, and 4700 rad/s where |G_1| falls to 0.708 A/V."""
    p = motor_drive.Parameters()
    n = 4
    A, B = np.zeros((n, n)), np.zeros(n)
    for i in range(n):
        at = np.zeros(n)
        at[i] = 1.0
        A[:, i] = rates(at, 0.0, p)
    B = rates(np.zeros(n), 1.0, p)
    moving = [0, 1, 3]  # the angle integrates and feeds back nothing
    A, B = A[np.ix_(moving, moving)], B[moving]
    omega = np.concatenate([[0.0], np.linspace(4000, 5500, 15_001)])
    G = np.abs([np.linalg.solve(1j * w * np.eye(3) - A, B)[0] for w in omega])
    assert G[0] == pytest.approx(0.887, rel=1e-9)
    falls = omega[1:][G[1:] < 10 ** (-3 / 20)][0]
    assert falls == pytest.approx(4658, rel=5e-3)


def rates(x: np.ndarray, v_m: float, p: motor_drive.Parameters) -> np.ndarray:
    winding = motor_drive.State().winding._replace(i=x[0], q=x[1])
    state = motor_drive.State(winding, x[2], x[3])
    rate = motor_drive.derivative(state, motor_drive.Input(v_m), p)
    return np.array([*rate.winding, rate.theta, rate.omega])
