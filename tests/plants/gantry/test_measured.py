"""The gantry as measured: the drive when its parts are off, each part when on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plants.gantry import drive, frame, measured
from plants.gantry.measured import Input, Parameters, State

small = st.floats(-1e-3, 1e-3)
PLAIN = Parameters()
ON = PLAIN._replace(
    pitch=PLAIN.pitch._replace(on=True),
    flexibility=PLAIN.flexibility._replace(on=True),
    coupling=PLAIN.coupling._replace(on=True),
)


@given(st.lists(small, min_size=14, max_size=14), st.lists(small, min_size=5))
def test_with_all_parts_off_it_is_the_drive(x: list[float], u: list[float]) -> None:
    state, inputs = State(drive.State(*x[:12]), *x[12:]), frame.Input(*u[:4])
    given_ = Input(*inputs, f_x=u[4])
    rates = measured.derivative(state, given_, PLAIN).drive
    assert rates == drive.derivative(state.drive, inputs, PLAIN.drive)
    found = measured.output(state, given_, PLAIN)
    assert found == drive.output(state.drive, inputs, PLAIN.drive)


def test_a_pull_of_57_newtons_bends_the_table_by_57_over_32_5_micrometres() -> None:
    y = measured.output(State(), Input(d_t=57 / 54), ON)
    assert y.y_t == pytest.approx(57 / 32.5 * 1e-6, rel=1e-12)
    assert (y.y_1, y.y_2) == (0.0, 0.0)


def test_the_motors_neither_drive_the_pitch_nor_see_it() -> None:
    pushed = measured.derivative(State(), Input(u_1=1.0, u_2=-3.0), ON)
    assert (pushed.q_p, pushed.v_p) == (0.0, 0.0)
    struck = measured.derivative(State(), Input(d_t=2.0), ON)
    assert struck.v_p == pytest.approx(2.0 / ON.pitch.m_q)
    y = measured.output(State(q_p=1e-6, v_p=1e-3), Input(), ON)
    assert (y.y_1, y.y_2, y.v_1, y.v_2, y.y_t) == (0.0, 0.0, 0.0, 0.0, 1e-6)


def test_a_rope_pulled_from_outside_leaves_the_base_alone() -> None:
    p = ON._replace(drive=ON.drive._replace(base=ON.drive.base._replace(on=True)))
    assert measured.derivative(State(), Input(d_t=1.0), p).drive.v_b == 0.0
    assert measured.derivative(State(), Input(u_1=1.0), p).drive.v_b > 0.0


@pytest.mark.parametrize("x", [-0.15, 0.0, 0.1])
def test_the_x_motor_turns_the_gantry_and_does_not_push_it(x: float) -> None:
    force = 3.0
    rates = measured.derivative(State(), Input(x=x, f_x=force), ON).drive
    g = frame.geometry(x, drive.mechanics(ON.drive))
    moved = (g.a_2 * rates.v_1 + g.a_1 * rates.v_2) / (g.a_1 + g.a_2)
    assert abs(moved) < 1e-15
    turn = (rates.v_2 - rates.v_1) / ON.drive.L
    assert turn == pytest.approx(force * ON.coupling.h / g.J, rel=1e-12)


def test_noise_of_an_amplifier_is_a_control_signal() -> None:
    noisy = measured.derivative(State(), Input(w_1=0.5, w_2=-0.25), ON)
    driven = measured.derivative(State(), Input(u_1=0.5, u_2=-0.25), ON)
    assert noisy == driven
    assert np.isfinite(noisy.drive.v_1)
