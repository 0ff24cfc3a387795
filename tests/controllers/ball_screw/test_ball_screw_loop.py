"""The study's figures from the model equations alone, on the exact plant.

This loop is the timing contract in its shortest form: at t_k the encoders are
read and the controller computes at once; what acts on the plant over
[t_k, t_{k+1}) is what it computed ``latency`` samples before.
"""

from collections import deque
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import signal

from controllers.ball_screw import mc_ppc, p_pi
from controllers.ball_screw._command import Inversion
from controllers.filters import prefilter
from controllers.references import trajectory
from plants.ball_screw import two_mass as ball_screw

T_s = 1 / 20_000
UM = 1e6 * ball_screw.Parameters().r_g  # µm of table motion per rad
MC_PPC = mc_ppc.Parameters()
P_PI_A = p_pi.Parameters()
P_PI_B = p_pi.Parameters(K_px=329.0, K_pv=0.668, K_iv=2.39)


@cache
def exact_plant() -> tuple[np.ndarray, np.ndarray]:
    """Return the zero-order-hold equivalent of eq. 3.1, written out by hand."""
    p = ball_screw.Parameters()
    m_1, m_2, b_1, b_2, k, c = p.m_1, p.m_2, p.b_1, p.b_2, p.k, p.c
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1
    A[2] = np.array([-k, k, -(c + b_1), c]) / m_1
    A[3] = np.array([k, -k, c, -(c + b_2)]) / m_2
    B = np.zeros((4, 2))
    B[2, 0], B[3, 1] = 1 / m_1, 1 / m_2
    discrete = signal.cont2discrete((A, B, np.eye(4), np.zeros((4, 2))), T_s)
    return discrete[0], discrete[1]


@cache
def command(v_max: float) -> trajectory.Output:
    """Return the record of the study: 20 ms of rest, the move, 150 ms."""
    p = trajectory.Parameters(v_max=v_max)
    k = np.arange(round((trajectory.move_time(p) + 0.17) / T_s) + 1, dtype=float)
    d = trajectory.prepare(p, T_s)
    _, y = trajectory.step(trajectory.State(k), trajectory.Input(), p, T_s, d)
    return trajectory.Output(*(np.broadcast_to(s, k.shape) for s in y))


def standstill(n: int) -> trajectory.Output:
    return trajectory.Output(*np.zeros((5, n)))


def closed_loop(
    controller: Any, p: Any, r: Any, *, d_2: float = 0.0, latency: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Return x_2 (rad) and the control signal u (V) at every tick."""
    A, B = exact_plant()
    d = controller.prepare(p, T_s)
    x_c, x = controller.State(), np.zeros(4)
    waiting = deque([0.0] * latency)
    x_2, u = np.empty_like(r.x_r), np.empty_like(r.x_r)
    for k, r_k in enumerate(zip(*(s.tolist() for s in r), strict=True)):
        x_2[k] = x[1]
        x_c, y = controller.step(x_c, controller.Input(*r_k, x[0], x[1]), p, T_s, d)
        u[k] = y.u
        waiting.append(y.u)
        x = A @ x + B @ [waiting.popleft(), d_2]
    return x_2, u


def tracking(controller: Any, p: Any, v_max: float) -> tuple[float, float, float]:
    """Return peak and RMS error (µm) and the largest control signal (V)."""
    r = command(v_max)
    x_2, u = closed_loop(controller, p, r)
    e_2 = (r.x_r - x_2) * UM
    return np.abs(e_2).max(), np.sqrt(np.mean(e_2**2)), np.abs(u).max()


@pytest.mark.parametrize(
    ("v_max", "peak", "rms", "u_peak"),
    [
        (0.2, 1.787, 0.298, 6.083),
        (0.5, 2.490, 0.818, 7.008),
        (1.0, 2.490, 1.433, 7.168),
    ],
)
def test_mc_ppc_tracks_as_computed_for_the_ideal_drive(
    v_max: float, peak: float, rms: float, u_peak: float
) -> None:
    found = tracking(mc_ppc, MC_PPC, v_max)
    assert found[0] == pytest.approx(peak, abs=0.005)
    assert found[1] == pytest.approx(rms, abs=0.003)
    assert found[2] == pytest.approx(u_peak, abs=0.01)


@pytest.mark.parametrize(("v_max", "peak"), [(0.2, 4.831), (0.5, 4.774), (1.0, 4.774)])
def test_p_pi_tracks_as_computed_for_the_ideal_drive(v_max: float, peak: float) -> None:
    assert tracking(p_pi, P_PI_A, v_max)[0] == pytest.approx(peak, abs=0.01)


def test_model_inversion_takes_most_of_the_error() -> None:
    p = MC_PPC._replace(inversion=Inversion(on=False))
    assert tracking(mc_ppc, p, 0.5)[0] == pytest.approx(17.295, abs=0.02)


def test_without_rotary_command_and_inversion_it_is_worse_again() -> None:
    p = MC_PPC._replace(inversion=Inversion(on=False), rotary=mc_ppc.Rotary(on=False))
    assert tracking(mc_ppc, p, 0.5)[0] > 20


def test_exact_derivatives_leave_a_tenth_of_a_micrometre() -> None:
    p = MC_PPC._replace(analytic=True)
    assert tracking(mc_ppc, p, 0.5)[0] == pytest.approx(0.11, abs=0.005)


def test_p_pi_without_velocity_feedforward_lags_by_velocity_over_gain() -> None:
    p = P_PI_A._replace(velocity_feedforward=False)
    assert tracking(p_pi, p, 0.5)[0] == pytest.approx(0.5 / 189 * 1e6, abs=0.5)


def test_prefilter_identified_at_500_mm_s_serves_all_speeds() -> None:
    r = command(0.5)
    x_2, _ = closed_loop(mc_ppc, MC_PPC, r)
    p, x, regressors = prefilter.Parameters(), prefilter.State(), []
    d = prefilter.prepare(p, T_s)
    for x_r in r.x_r.tolist():
        x, y = prefilter.step(x, prefilter.Input(x_r), p, T_s, d)
        regressors.append(y[1:])
    norm = np.linalg.norm(regressors, axis=0)
    K = np.linalg.lstsq(regressors / norm, r.x_r - x_2, rcond=None)[0] / norm
    assert K[1] == pytest.approx(2.537e-7, rel=0.005)

    gains = prefilter.Gains(*K)
    for v_max, peak in ((0.2, 0.087), (0.5, 0.063), (1.0, 0.063)):
        found = tracking(mc_ppc, MC_PPC._replace(pre=gains), v_max)[0]
        assert found == pytest.approx(peak, abs=0.01), f"{v_max} m/s"


@pytest.mark.parametrize(
    ("controller", "p", "peak", "settling"),
    [
        (mc_ppc, MC_PPC, 29.714, 14.35e-3),
        (p_pi, P_PI_A, 30.522, 31.65e-3),
        (p_pi, P_PI_B, 30.33, 0.633),
    ],
    ids=["mc_ppc", "p_pi_a", "p_pi_b"],
)
def test_rope_snap(controller: Any, p: Any, peak: float, settling: float) -> None:
    x_2, _ = closed_loop(controller, p, standstill(15_000), d_2=1.0)
    away = np.abs(x_2) * UM
    assert away.max() == pytest.approx(peak, abs=0.02)
    last_out = np.flatnonzero(away > 0.05 * away.max())[-1]
    assert (last_out + 1) * T_s == pytest.approx(settling, rel=0.002)


def matched(roots: np.ndarray) -> np.ndarray:
    return np.real(np.poly(np.exp(np.asarray(roots) * T_s)))


def filter_pack() -> tuple[np.ndarray, np.ndarray]:
    """Return the filter pack's matched numerator and denominator."""
    w = 2 * np.pi * np.array([420.0, 1080.0])
    zeta_z, zeta_p = np.array([0.55, 0.05]), np.array([0.7, 0.7])
    q = [np.roots([1, 2 * z * v, v * v]) for z, v in zip(zeta_z, w, strict=True)]
    r = [np.roots([1, 2 * z * v, v * v]) for z, v in zip(zeta_p, w, strict=True)]
    b = np.convolve(matched(np.concatenate(q)), [1, 1])
    a = matched(np.concatenate([*r, [-2 * np.pi * 2000]]))
    return b * a.sum() / b.sum(), a


def reference(name: str, x_r: np.ndarray, latency: int) -> np.ndarray:
    """Return x_2 (rad) of a loop written without any of the run-time modules."""
    p = ball_screw.Parameters()
    m, b, k, c = p.m_1 + p.m_2, p.b_1 + p.b_2, p.k, p.c
    difference = signal.lfilter([1, -1], [1], x_r)
    if name == "mc_ppc":
        pole = np.exp(-k * T_s / c)
        zeros = matched(np.roots([p.m_2, p.b_2 + c, k]))
        x_1r = signal.lfilter(zeros * (1 - pole) / zeros.sum(), [1, -pole], x_r)
        a_1 = p.m_1 * p.b_2 + p.m_2 * p.b_1 + m * c
        roots = np.roots([p.m_1 * p.m_2, a_1, p.b_1 * p.b_2 + b * c + m * k, b * k])
        real = roots[np.abs(roots.imag) < 1e-9].real[0]
        axial = matched(roots[np.abs(roots.imag) > 1e-9])
        gain = b * (1 - pole) / (T_s * -np.expm1(real * T_s) * axial.sum())
        u_ff = signal.lfilter([1, -np.exp(real * T_s)], [1], difference)
        u_ff = gain * signal.lfilter(axial, [1, -pole], u_ff)
        K = MC_PPC.gains
        # proportional, difference and summing gain on (x_1r - y_1, x_r - y_2)
        r = np.column_stack([x_1r, x_r])
        P, D, S = [K.K_x1, K.K_x2], [K.K_v1 / T_s, K.K_v2 / T_s], [0, K.K_i2 * T_s]
    else:
        # v_e = K_px e_2 + D e_1 with the command of both axes x_r; its sum over
        # time is K_px times the sum of e_2 plus e_1
        K_px, K_pv, K_iv = P_PI_A.K_px, P_PI_A.K_pv, P_PI_A.K_iv
        r = np.column_stack([x_r, x_r])
        P, D, S = [K_iv, K_pv * K_px], [K_pv / T_s, 0], [0, K_iv * T_s * K_px]
        second = signal.lfilter([1, -1], [1], difference)
        u_ff = m * second / T_s**2 + b * difference / T_s
    A, B = exact_plant()
    A_f, B_f, C_f, D_f = signal.tf2ss(*filter_pack())
    x, w, e_before, total = np.zeros(4), np.zeros(5), np.zeros(2), np.zeros(2)
    waiting, x_2 = deque([0.0] * latency), np.empty_like(x_r)
    for i in range(len(x_r)):
        x_2[i] = x[1]
        e = r[i] - x[:2]
        total = total + e
        v = np.dot(P, e) + np.dot(D, e - e_before) + np.dot(S, total)
        waiting.append(C_f[0] @ w + D_f[0, 0] * v + u_ff[i])
        w, e_before = A_f @ w + B_f[:, 0] * v, e
        x = A @ x + B[:, 0] * waiting.popleft()
    return x_2


@pytest.mark.parametrize("latency", [0, 1, 2])
@pytest.mark.parametrize("name", ["mc_ppc", "p_pi"])
def test_whole_controller_equals_an_independent_loop(name: str, latency: int) -> None:
    r = command(1.0)
    controller, p = {"mc_ppc": (mc_ppc, MC_PPC), "p_pi": (p_pi, P_PI_A)}[name]
    x_2, _ = closed_loop(controller, p, r, latency=latency)
    assert np.max(np.abs(x_2 - reference(name, r.x_r, latency))) < 1e-9


def test_runge_kutta_substeps_of_the_plant_keep_a_move_to_a_nanoradian() -> None:
    p, h = ball_screw.Parameters(), ball_screw.model.h_max
    columns = []
    for state in np.eye(4):
        f = ball_screw.derivative(ball_screw.State(*state), ball_screw.Input(), p)
        columns.append(f)
    A = np.transpose(columns)
    B = np.array(ball_screw.derivative(ball_screw.State(), ball_screw.Input(1.0), p))
    M = np.zeros((5, 5))
    M[:4, :4], M[:4, 4] = A, B
    power = np.eye(5)
    substep = np.eye(5)
    for order in range(1, 5):
        power = power @ M * (h / order)
        substep = substep + power
    step = np.linalg.matrix_power(substep, round(T_s / h))
    exact, B_exact = exact_plant()
    _, u = closed_loop(mc_ppc, MC_PPC, command(1.0))
    x, y = np.zeros(4), np.zeros(4)
    worst = 0.0
    for u_k in u:
        x = exact @ x + B_exact[:, 0] * u_k
        y = step[:4, :4] @ y + step[:4, 4] * u_k
        worst = max(worst, abs(x[1] - y[1]))
    assert worst < 1e-9
