"""The drive's mechanics against the published modes, and every part's switch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmus.model import Continuous, Record, pack, unpack
from plants.ball_screw import current_loop, pitch_mode
from plants.ball_screw import drive as ball_screw_drive
from plants.ball_screw import two_mass as ball_screw
from plants.ball_screw._friction import Stribeck, friction

signal = st.floats(-10, 10)
BARE = ball_screw.Parameters()
DRIVE = ball_screw_drive.Parameters()


def system_matrix(p: ball_screw.Parameters) -> np.ndarray:
    """Return A of ẋ = A x, column by column: the equations are linear."""
    states = (ball_screw.State(*e) for e in np.eye(4))
    at_rest = ball_screw.Input()
    return np.transpose([ball_screw.derivative(x, at_rest, p) for x in states])


def response(
    model: Continuous, u: Record, p: Record, t: float, x: Record | None = None
) -> Record:
    """Return the state after t seconds of constant input."""

    def f(_: float, x: np.ndarray) -> np.ndarray:
        return pack(model.derivative(unpack(model.state, x), u, p))

    start = pack(model.state if x is None else x)
    done = solve_ivp(f, (0, t), start, method="LSODA", rtol=1e-10, atol=1e-13)
    return unpack(model.state, done.y[:, -1])


def test_modes_are_the_published_ones() -> None:
    poles = np.linalg.eigvals(system_matrix(BARE))
    axial = poles[poles.imag > 1][0]
    assert abs(axial) / (2 * np.pi) == pytest.approx(129.9993, abs=1e-4)
    assert -axial.real / abs(axial) == pytest.approx(0.0272813, abs=1e-7)
    rigid = np.sort(poles[np.abs(poles.imag) < 1].real)
    assert rigid == pytest.approx([-0.4559678, 0.0], abs=1e-7)


def test_forces_between_the_masses_cancel() -> None:
    p = BARE._replace(b_1=0.0, b_2=0.0)
    a = ball_screw.derivative(ball_screw.State(1, -2, 3, 5), ball_screw.Input(), p)
    momentum_rate = p.m_1 * a.v_1 + p.m_2 * a.v_2
    assert momentum_rate == pytest.approx(0.0, abs=1e-12 * p.k)


@given(st.floats(-8e-4, 8e-4), signal, signal, signal)
def test_coupled_inertias_solve_the_full_mass_matrix(
    m_12: float, u: float, d_1: float, d_2: float
) -> None:
    p = BARE._replace(m_12=m_12)
    x, inputs = ball_screw.State(0.3, -0.2, 7.0, -4.0), ball_screw.Input(u, d_1, d_2)
    a = ball_screw.derivative(x, inputs, p)
    nut = p.k * (x.x_2 - x.x_1) + p.c * (x.v_2 - x.v_1)
    forces = [nut - p.b_1 * x.v_1 + u + d_1, -nut - p.b_2 * x.v_2 + d_2]
    mass = [[p.m_1, m_12], [m_12, p.m_2]]
    assert (a.v_1, a.v_2) == pytest.approx(np.linalg.solve(mass, forces), rel=1e-9)


def test_table_position_is_in_metres() -> None:
    y = ball_screw.output(ball_screw.State(x_2=2 * np.pi), ball_screw.Input(), BARE)
    assert y.x_t == pytest.approx(0.020)


@given(st.lists(signal, min_size=11, max_size=11), signal, signal, signal)
def test_drive_with_all_parts_off_is_the_bare_ball_screw(
    x: list[float], u: float, d_1: float, d_2: float
) -> None:
    full = ball_screw_drive.State(*x)
    inputs = ball_screw.Input(u, d_1, d_2)
    bare = ball_screw.State(*x[:4])
    rates = ball_screw_drive.derivative(full, inputs, DRIVE)
    assert rates[:4] == ball_screw.derivative(bare, inputs, BARE)
    found = ball_screw_drive.output(full, inputs, DRIVE)
    assert found == ball_screw.output(bare, inputs, BARE)


def test_drive_has_the_bare_plants_ports_and_parameters() -> None:
    assert ball_screw_drive.Input is ball_screw.Input
    assert ball_screw_drive.Output is ball_screw.Output
    bare = BARE._asdict()
    assert {name: getattr(DRIVE, name) for name in bare} == bare


def test_current_loop_reaches_63_percent_after_its_time_constant() -> None:
    p = current_loop.Parameters()
    tau = 1 / (2 * np.pi * 450)
    u_a = response(current_loop.model, current_loop.Input(1.0), p, tau).u_a
    assert u_a == pytest.approx(1 - np.exp(-1), abs=1e-8)


def test_current_loop_in_the_drive_is_the_current_loop_before_the_bare_plant() -> None:
    p = DRIVE._replace(current_loop=ball_screw_drive.CurrentLoop(on=True))
    whole = response(ball_screw_drive.model, ball_screw.Input(1.0), p, 0.01)

    def split(_: float, x: np.ndarray) -> np.ndarray:
        lag = current_loop.derivative(
            current_loop.State(x[4]), current_loop.Input(1.0), current_loop.Parameters()
        )
        u = ball_screw.Input(x[4])
        masses = ball_screw.derivative(ball_screw.State(*x[:4]), u, BARE)
        return np.array([*masses, *lag])

    done = solve_ivp(
        split, (0, 0.01), np.zeros(5), method="LSODA", rtol=1e-10, atol=1e-13
    )
    assert whole[:5] == pytest.approx(done.y[:, -1], rel=1e-6, abs=1e-9)


def test_pitch_is_seen_by_the_linear_encoder_and_not_excited_by_the_motor() -> None:
    p = DRIVE._replace(pitch=ball_screw_drive.Pitch(on=True, zeta=1.0))
    driven = response(ball_screw_drive.model, ball_screw.Input(u=1.0), p, 0.02)
    assert driven.q == 0.0
    u = ball_screw.Input(d_2=1.0)
    pushed = response(ball_screw_drive.model, u, p, 0.2)
    assert pushed.q == pytest.approx(p.pitch.gamma, rel=1e-6)
    y = ball_screw_drive.output(pushed, u, p)
    assert y.x_2 - pushed.x_2 == pytest.approx(pushed.q, rel=1e-9)
    assert y.x_t == pytest.approx(p.r_g * y.x_2)
    alone = pitch_mode.Parameters(zeta=1.0)
    q = response(pitch_mode.model, pitch_mode.Input(1.0), alone, 0.2).q
    assert q == pytest.approx(pushed.q, rel=1e-9)


def test_pitch_rings_at_43_hz() -> None:
    p = pitch_mode.Parameters(zeta=0.0)
    x = response(pitch_mode.model, pitch_mode.Input(1.0), p, 1 / 43)
    assert x.q == pytest.approx(0.0, abs=1e-9)
    half = response(pitch_mode.model, pitch_mode.Input(1.0), p, 0.5 / 43)
    assert half.q == pytest.approx(2e-3, rel=1e-6)


def test_torsional_modes_add_their_static_compliance_to_the_screw() -> None:
    torsion = ball_screw_drive.Torsion(
        on=True, zeta_1=1.0, zeta_2=1.0, r_1=3.0, r_2=5.0
    )
    p = DRIVE._replace(torsion=torsion)
    u = ball_screw.Input(u=2.0)
    x = response(ball_screw_drive.model, u, p, 0.05)
    omega = 2 * np.pi * np.array([440.0, 1100.0])
    twist = 2 * (3 / omega[0] ** 2 + 5 / omega[1] ** 2)
    y = ball_screw_drive.output(x, u, p)
    assert y.x_1 - x.x_1 == pytest.approx(twist, rel=1e-6)


def test_friction_slows_the_screw_and_nothing_else() -> None:
    p = DRIVE._replace(friction=Stribeck(on=True))
    x = ball_screw_drive.State(v_1=100.0, v_2=100.0)
    free = ball_screw_drive.derivative(x, ball_screw.Input(), DRIVE)
    braked = ball_screw_drive.derivative(x, ball_screw.Input(), p)
    assert braked.v_1 - free.v_1 == pytest.approx(-0.12 / p.m_1, rel=1e-9)
    assert braked.v_2 == free.v_2


@given(st.floats(0.5, 200), st.sampled_from([-1, 1]))
def test_friction_is_the_sources_law_away_from_standstill(v: float, way: int) -> None:
    p = Stribeck(True, 0.10, 0.14, 0.20, 0.26)
    d_c, d_s = (0.10, 0.20) if way > 0 else (0.14, 0.26)
    expected = way * (d_c + (d_s - d_c) * np.exp(-v / p.Omega))
    assert friction(way * v, p) == pytest.approx(expected, rel=1e-7)


@given(st.floats(-1e3, 1e3))
def test_friction_always_opposes_motion(v: float) -> None:
    assert friction(v, Stribeck(on=True)) * v >= 0
    assert friction(v, Stribeck(on=False)) == 0
