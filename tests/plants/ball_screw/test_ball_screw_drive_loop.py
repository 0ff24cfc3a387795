"""The study's figures that need the drive's parts besides the two masses."""

from collections import deque
from typing import Any

import numpy as np
import pytest
from scipy import signal

from controllers.ball_screw import mc_ppc, p_pi
from controllers.references import trajectory
from fmus.model import pack, unpack
from plants.ball_screw import drive as ball_screw_drive
from plants.disturbances import sine as excitation
from plants.disturbances import slotting_force

T_s = 1 / 20_000
DRIVE = ball_screw_drive.Parameters()
UM = 1e6 * DRIVE.r_g  # µm of table motion per rad
CURRENT = DRIVE._replace(current_loop=ball_screw_drive.CurrentLoop(on=True))
PITCH = DRIVE._replace(pitch=ball_screw_drive.Pitch(on=True))
MC_PPC, P_PI_A = (mc_ppc, mc_ppc.Parameters()), (p_pi, p_pi.Parameters())
P_PI_B = p_pi, p_pi.Parameters(K_px=329.0, K_pv=0.668, K_iv=2.39)


def zero_order_hold(p: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B and C of the drive without friction, for u and d_2."""
    m = ball_screw_drive.model
    states = [unpack(m.state, e) for e in np.eye(11)]
    A = np.transpose([pack(m.derivative(x, m.input, p)) for x in states])
    inputs = [m.input._replace(u=1.0), m.input._replace(d_2=1.0)]
    B = np.transpose([pack(m.derivative(m.state, u, p)) for u in inputs])
    C = np.transpose([m.output(x, m.input, p)[:2] for x in states])
    A, B, *_ = signal.cont2discrete((A, B, C, np.zeros((2, 2))), T_s)
    return A, B, C


def closed_loop(
    controller: Any, drive: Any, r: Any, d_2: np.ndarray, u_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the linear encoder (rad) and the control signal, one sample late."""
    (law, p), (A, B, C) = controller, zero_order_hold(drive)
    d, x_c, x = law.prepare(p, T_s), law.State(), np.zeros(11)
    waiting, y_2, u = deque([0.0]), np.empty(len(d_2)), np.empty(len(d_2))
    for k, r_k in enumerate(zip(*(s.tolist() for s in r), strict=True)):
        y = C @ x
        x_c, out = law.step(x_c, law.Input(*r_k, *y, u_d[k]), p, T_s, d)
        y_2[k], u[k] = y[1], out.u
        waiting.append(out.u)
        x = A @ x + B @ [waiting.popleft(), d_2[k]]
    return y_2, u


def sources(n: int) -> np.ndarray:
    return np.arange(n, dtype=float)


def command(v_max: float) -> trajectory.Output:
    p = trajectory.Parameters(v_max=v_max)
    k = sources(round((trajectory.move_time(p) + 0.17) / T_s) + 1)
    d = trajectory.prepare(p, T_s)
    _, y = trajectory.step(trajectory.State(k), trajectory.Input(), p, T_s, d)
    return trajectory.Output(*(np.broadcast_to(s, k.shape) for s in y))


@pytest.mark.parametrize(
    ("controller", "settling"),
    [(MC_PPC, 0.198), (P_PI_A, 0.148), (P_PI_B, 0.637)],
    ids=["mc_ppc", "p_pi_a", "p_pi_b"],
)
def test_pitch_stretches_the_settling_of_a_rope_snap(
    controller: Any, settling: float
) -> None:
    n = 15_000
    y_2, _ = closed_loop(controller, PITCH, np.zeros((5, n)), np.ones(n), np.zeros(n))
    last_out = np.flatnonzero(np.abs(y_2) > 0.05 * np.abs(y_2).max())[-1]
    assert (last_out + 1) * T_s == pytest.approx(settling, abs=5e-4)


@pytest.mark.parametrize(
    ("v_max", "peak", "rms"), [(0.2, 7.2, 1.14), (0.5, 6.0, 1.58), (1.0, 6.0, 1.84)]
)
def test_current_loop_costs_p_pi_more_than_a_micrometre(
    v_max: float, peak: float, rms: float
) -> None:
    r = command(v_max)
    nothing = np.zeros_like(r.x_r)
    e_2 = (r.x_r - closed_loop(P_PI_A, CURRENT, r, nothing, nothing)[0]) * UM
    assert np.abs(e_2).max() == pytest.approx(peak, abs=0.05)
    assert np.sqrt(np.mean(e_2**2)) == pytest.approx(rms, abs=0.006)


@pytest.mark.parametrize(
    ("controller", "peak"), [(MC_PPC, 7.8), (P_PI_A, 8.0)], ids=["mc_ppc", "p_pi_a"]
)
def test_slotting_at_200_mm_s(controller: Any, peak: float) -> None:
    r = command(0.2)
    k = slotting_force.State(sources(len(r.x_r)))
    p = slotting_force.Parameters()
    _, y = slotting_force.step(k, slotting_force.Input(), p, T_s)
    y_2, _ = closed_loop(controller, DRIVE, r, y.d_2, np.zeros_like(r.x_r))
    assert np.abs(r.x_r - y_2).max() * UM == pytest.approx(peak, abs=0.05)


def test_sine_at_the_input_shows_the_sensitivity_peak_of_mc_ppc() -> None:
    n, f_hz = 20_000, 165.0
    p = excitation.Parameters(f_hz=f_hz)
    k = sources(n)
    _, y = excitation.step(excitation.State(k), excitation.Input(), p, T_s)
    _, u = closed_loop(MC_PPC, CURRENT, np.zeros((5, n)), np.zeros(n), y.d)
    settled = slice(n - 8_000, n)  # 66 whole periods
    turn = np.exp(-2j * np.pi * f_hz * T_s * k)[settled]
    s = np.dot(u[settled], turn) / np.dot(y.d[settled], turn)
    assert abs(s) == pytest.approx(3.294, abs=0.003)
