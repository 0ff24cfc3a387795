"""The gantry's plants against the source's transfer functions and each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.synthesis.linearise import linearise
from controllers.synthesis.parameters import with_values
from fmus.model import unpack
from plants.disturbances import multisine
from plants.gantry import drive as gantry_drive
from plants.gantry import encoder as gantry_encoder
from plants.gantry import frame as gantry
from plants.gantry import x_axis as linear_motor
from plants.gantry import x_drive as linear_motor_drive

p = gantry.Parameters()
T_s = 1 / 15_000
places = st.floats(-0.15, 0.15)


def response(model, f_hz, names, **values):
    """Response of a linearised model at frequencies, (n, outputs, inputs)."""
    system = linearise(model, inputs=names[0], outputs=names[1], **values)
    return np.moveaxis(system.horner(2j * np.pi * f_hz), -1, 0)


@given(x=places)
def test_the_traced_gantry_has_the_transfer_matrix_of_the_source(x):
    f_hz = np.array([5.0, 60.0, 94.0, 300.0])
    J = 0.4342 + 0.6977 * (0.1655 + x) ** 2
    a_1 = 1.484 / 2 - 0.1655 * (1 - 0.6977 / 2.722) + 0.6977 / 2.722 * x
    b = np.array([-a_1, 1.484 - a_1])
    s = 2j * np.pi * f_hz[:, None, None]
    expected = 1 / (2.722 * s**2) + np.outer(b, b) / (J * s**2 + 18.17 * s + 159200)
    G = response(
        gantry.model, f_hz, (["u_1", "u_2"], ["y_1", "y_2"]), input=gantry.Input(x=x)
    )
    assert pytest.approx(expected, rel=1e-9) == G


@given(x=places, values=st.lists(st.floats(-1, 1), min_size=7, max_size=7))
def test_the_ends_obey_the_mass_matrix_of_the_end_form(x, values):
    y_1, y_2, v_1, v_2, u_1, u_2, d_t = values
    g = gantry.geometry(x, p)
    M = np.array(
        [
            [g.a_2**2 * p.m + g.J, g.a_1 * g.a_2 * p.m - g.J],
            [g.a_1 * g.a_2 * p.m - g.J, g.a_1**2 * p.m + g.J],
        ]
    )
    state = gantry.State(1e-6 * y_1, 1e-6 * y_2, v_1, v_2)
    slope = gantry.derivative(state, gantry.Input(u_1, u_2, d_t, x), p)
    twist = p.c * (v_1 - v_2) + 1e-6 * p.k * (y_1 - y_2)
    # a force at the table splits on the ends by the lever rule
    far = (p.L / 2 + x) / p.L
    forces = np.array([u_1 + (1 - far) * d_t, u_2 + far * d_t])
    springs = np.array([-twist, twist]) / p.L**2
    left = M / p.L**2 @ np.array([slope.v_1, slope.v_2])
    assert left == pytest.approx(forces + springs, abs=1e-12)


def test_a_moving_table_does_not_move_the_ends():
    state = gantry.State(1e-3, -2e-3, 0.1, 0.3)
    for x in (-0.15, 0.15):
        y = gantry.output(state, gantry.Input(x=x), p)
        assert (y.y_1, y.y_2, y.v_1, y.v_2) == state


def test_the_table_is_on_the_line_through_both_ends():
    state = gantry.State(y_1=1.0, y_2=2.0)
    positions = [
        gantry.output(state, gantry.Input(x=x), p).y_t for x in (-0.742, 0, 0.742)
    ]
    assert positions == pytest.approx([1.0, 1.5, 2.0])


def test_a_payload_acts_like_a_heavier_table():
    heavy = gantry.geometry(0.1, p._replace(m_p=0.3))
    total = p._replace(m=p.m + 0.3, m_x=p.m_x + 0.3)
    light = gantry.geometry(0.1, p)
    # moments about the left motor
    assert heavy.m == pytest.approx(total.m)
    assert heavy.a_1 * heavy.m == pytest.approx(light.a_1 * p.m + 0.3 * (p.L / 2 + 0.1))
    assert pytest.approx(gantry.geometry(0.1, total).J) == heavy.J


@given(values=st.lists(st.floats(-1, 1), min_size=16, max_size=16))
def test_drives_with_everything_off_are_the_plain_plants(values):
    x = unpack(gantry_drive.State(), np.array(values[:12]))
    u = gantry.Input(*values[12:])
    rigid = gantry.State(*x[:4])
    slope = gantry_drive.derivative(x, u, gantry_drive.Parameters())
    assert slope[:4] == gantry.derivative(rigid, u, p)
    assert gantry_drive.output(x, u, gantry_drive.Parameters()) == pytest.approx(
        gantry.output(rigid, u, p)
    )
    table, force = (
        linear_motor_drive.State(*values[:3]),
        linear_motor.Input(*values[:2]),
    )
    moved = linear_motor_drive.derivative(table, force, linear_motor_drive.Parameters())
    plain = linear_motor.State(*values[:2])
    assert moved[:2] == linear_motor.derivative(plain, force, linear_motor.Parameters())


def test_a_mode_of_the_drive_is_a_compliance_beside_the_yaw():
    f_hz = np.array([10.0, 36.0, 90.0])
    on = with_values(gantry_drive.Parameters(), {"base.on": True, "amplifier.on": True})
    names = ["u_1", "u_2"], ["y_1", "y_2"]
    plain = response(gantry.model, f_hz, names)
    s, w = 2j * np.pi * f_hz, 2 * np.pi * 36.0
    lag = 1 / (1 + s / (2 * np.pi * 221.28))
    base = 1 / 13.61 / (s**2 + 2 * 0.03 * w * s + w**2)
    expected = (plain + base[:, None, None]) * lag[:, None, None]
    drive = response(gantry_drive.model, f_hz, names, parameters=on)
    assert drive == pytest.approx(expected, rel=1e-9)


def test_ripple_repeats_with_the_magnetic_pitch():
    values = {"ripple.on": True, "ripple.A_r": 0.1}
    ripple = with_values(linear_motor_drive.Parameters(), values)

    def force(x):
        state = linear_motor_drive.State(x=x)
        still = linear_motor.Input()
        return linear_motor_drive.derivative(state, still, ripple).v * ripple.m_x

    assert force(0.008) == pytest.approx(0.1)
    assert force(0.008 + 0.032) == pytest.approx(0.1)


@given(x=st.floats(-0.2, 0.2))
def test_an_encoder_reads_the_nearest_step(x):
    on = gantry_encoder.Parameters(on=True)
    _, y = gantry_encoder.step(
        gantry_encoder.State(), gantry_encoder.Input(x, -x, x), on, T_s
    )
    assert abs(y.x_m - x) <= 5e-9 * (1 + 1e-6)
    assert y.x_m / 10e-9 == pytest.approx(round(y.x_m / 10e-9), abs=1e-6)


def test_the_multisine_has_equal_lines_one_motor_at_a_time_and_a_low_peak():
    k = np.arange(45_000.0)
    _, y = multisine.step(
        multisine.State(k), multisine.Input(), multisine.Parameters(), T_s
    )
    assert not np.any(y.d_1[22_500:])
    assert not np.any(y.d_2[:22_500])
    for signal, start in ((y.d_1, 7_500), (y.d_2, 30_000)):
        lines = np.abs(np.fft.rfft(signal[start : start + 15_000])) / 7_500
        assert lines[60:151] == pytest.approx(np.full(91, 0.05))
        assert np.max(np.delete(lines, np.arange(60, 151))) < 1e-12
        # the sum of 91 lines in phase would reach 4.55 V
        assert np.max(np.abs(signal)) < 0.75
