"""The drive as measured: the drive when its parts are off, its equations when on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.synthesis.ball_screw.loops import (
    continuous_loop,
    measured_loops,
    sampled_loop,
)
from controllers.synthesis.frequency import poles, respond
from plants.ball_screw import drive, measured
from plants.ball_screw.measured import LeadError, LostMotion, Parameters, State
from plants.ball_screw.two_mass import Input

signal = st.floats(-10, 10)
PLAIN = Parameters()
R_G = PLAIN.drive.r_g
DAMPING = {"plant.torsion.zeta_1": 0.1, "plant.torsion.zeta_2": 0.1}


@given(st.lists(signal, min_size=12, max_size=12), signal, signal, signal)
def test_with_all_parts_off_it_is_the_drive(
    x: list[float], u: float, d_1: float, d_2: float
) -> None:
    state, inputs = State(drive.State(*x[:11]), x[11]), Input(u, d_1, d_2)
    rates = measured.derivative(state, inputs, PLAIN)
    assert rates.drive == drive.derivative(state.drive, inputs, PLAIN.drive)
    assert rates.v_a == 0
    found = measured.output(state, inputs, PLAIN)
    assert found == drive.output(state.drive, inputs, PLAIN.drive)


@given(signal, signal, signal)
def test_a_lead_error_neither_makes_nor_loses_power(x_1: float, v_1: float, v_2: float):
    p = PLAIN._replace(lead_error=LeadError(True, 20e-6, 0.4))
    p = p._replace(drive=p.drive._replace(b_1=0.0, c=0.0))
    x = State(drive.State(x_1=x_1, x_2=x_1 + 1e-3, v_1=v_1, v_2=v_2))
    k = measured.derivative(x, Input(), p).drive
    A = p.lead_error.A / R_G
    wound = x.drive.x_2 - x_1 - A * np.sin(x_1 + 0.4)
    stored = p.drive.k * wound * (v_2 - v_1 - A * np.cos(x_1 + 0.4) * v_1)
    moving = p.drive.m_1 * v_1 * k.v_1 + p.drive.m_2 * v_2 * k.v_2
    scale = p.drive.k * abs(wound) * (abs(v_1) + abs(v_2)) + 1e-9
    assert abs(moving + stored) < 1e-11 * scale


@pytest.mark.parametrize(("gap", "force"), [(0.4e-6, 0.0), (2e-6, 1.0)])
def test_a_nut_with_lost_motion_pushes_only_beyond_half_its_gap(gap, force) -> None:
    p = PLAIN._replace(lost_motion=LostMotion(True, 2e-6))
    x = State(drive.State(x_2=gap / R_G))
    pulled = p.drive.m_2 * measured.derivative(x, Input(), p).drive.v_2
    assert pulled == pytest.approx(-force * p.drive.k * 1e-6 / R_G, abs=1e-12)


def test_a_mode_of_shape_one_is_seen_alike_by_both_encoders() -> None:
    torsion = drive.Torsion(on=True)
    p = Parameters(drive.Parameters(torsion=torsion), shapes=measured.Shapes(1.0, -0.5))
    x = State(drive.State(q_1=0.25, v_q1=3.0, q_2=1.0, v_q2=-2.0))
    y = measured.output(x, Input(), p)
    assert (y.x_1, y.x_2, y.v_1, y.v_2) == (1.25, -0.25, 1.0, 4.0)
    assert y.x_t == pytest.approx(-0.25 * R_G)


def test_a_current_loop_of_second_order_rings_at_its_frequency() -> None:
    p = Parameters(
        drive.Parameters(current_loop=drive.CurrentLoop(True, 450.0)),
        second_order=measured.SecondOrder(True, 0.4),
    )
    A = np.transpose(
        [
            (k.drive.u_a, k.v_a)
            for k in (
                measured.derivative(State(drive.State(u_a=1.0)), Input(), p),
                measured.derivative(State(v_a=1.0), Input(), p),
            )
        ]
    )
    pole = np.linalg.eigvals(A)[0]
    assert abs(pole) / (2 * np.pi) == pytest.approx(450, rel=1e-12)
    assert -pole.real / abs(pole) == pytest.approx(0.4, rel=1e-12)
    driven = measured.derivative(State(drive.State(u_a=2.0)), Input(u=2.0), p)
    assert abs(driven.v_a) < 1e-6  # at rest where the torque is the command


def test_with_one_pole_its_loop_is_that_of_the_drive() -> None:
    f_hz = np.geomspace(10, 900, 20)
    continuous, sampled = measured_loops("mc_ppc")
    plain = continuous_loop("mc_ppc", True, {}), sampled_loop("mc_ppc", True, {})
    for found, known in zip((continuous, sampled), plain, strict=True):
        same = respond(known, f_hz).L
        assert pytest.approx(same, rel=1e-9) == respond(found, f_hz).L


def test_the_audits_residues_give_its_peaks_in_a_loop_that_is_unstable() -> None:
    parts = {"second_order.on": 1.0, "torsion.on": 1.0}
    audit = {"plant.torsion.r_1": 911.0, "plant.torsion.r_2": -3927.0}
    loops = measured_loops("mc_ppc", **parts, **DAMPING, **audit)
    f_hz = np.linspace(20, 300, 2801)
    peaks = [np.max(1 / np.abs(1 + respond(loop, f_hz).L)) for loop in loops]
    assert peaks == pytest.approx([2.348, 3.023], abs=1e-3)
    decay, radius = np.max(poles(loops[0]).real), np.max(np.abs(poles(loops[1])))
    assert decay == pytest.approx(266.88, abs=0.1)
    assert radius == pytest.approx(1.01268, abs=1e-5)


def test_of_the_study_s_residues_the_loop_is_stable_and_has_no_higher_peak() -> None:
    parts = {"second_order.on": 1.0, "second_order.zeta": 0.35, "torsion.on": 1.0}
    ours = {"plant.torsion.r_1": -350.0, "plant.torsion.r_2": 3800.0}
    loops = measured_loops("mc_ppc", **parts, **DAMPING, **ours)
    assert np.max(poles(loops[0]).real) < -100
    assert np.max(np.abs(poles(loops[1]))) < 0.99
    f_hz = np.geomspace(20, 9000, 4000)
    peaks = [np.max(1 / np.abs(1 + respond(loop, f_hz).L)) for loop in loops]
    assert peaks == pytest.approx([2.354, 3.031], abs=2e-3)
