"""Encoder and process loads: exact instants, exact phase, exact steps."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.model import Record, Sampled
from fmus.ticks import sine, tick_of
from plants.ball_screw import encoder
from plants.disturbances import chirp, rope_snap, slotting_force
from plants.disturbances import sine as excitation

T_s = 1 / 20_000


def record(model: Sampled, p: Record, k: np.ndarray) -> np.ndarray:
    """Return the one output of a source at the ticks k."""
    x = model.state._replace(k=k.astype(float))
    _, y = model.step(x, model.input, p, T_s)
    return np.asarray(y[0])


ON = encoder.Parameters(on=True)
STEP = ON.q / ON.r_g


@given(st.floats(-100, 100), st.floats(-100, 100))
def test_encoder_reads_the_nearest_step_of_either_axis(x_1: float, x_2: float) -> None:
    _, y = encoder.step(encoder.State(), encoder.Input(x_1, x_2), ON, T_s)
    for reading, x in ((y.y_1, x_1), (y.y_2, x_2)):
        assert abs(reading - x) <= STEP / 2 * (1 + 1e-6)
        assert reading / STEP == pytest.approx(round(reading / STEP), abs=1e-6)


@given(st.floats(-100, 100), st.floats(-100, 100))
def test_encoder_switched_off_is_exact(x_1: float, x_2: float) -> None:
    u = encoder.Input(x_1, x_2)
    _, y = encoder.step(encoder.State(), u, encoder.Parameters(), T_s)
    assert y == (x_1, x_2)


def test_encoder_step_is_ten_nanometres_of_the_table() -> None:
    assert pytest.approx(3.14159e-6, rel=1e-6) == STEP


@given(st.fractions(0, 100, max_denominator=20_000), st.integers(1, 40_000))
def test_a_time_on_a_tick_is_that_tick(t: Fraction, rate_hz: int) -> None:
    tick = Fraction(int(t * rate_hz), rate_hz)
    assert tick_of(float(tick), 1 / rate_hz) == tick * rate_hz


def test_rope_snaps_once_and_for_good() -> None:
    p = rope_snap.Parameters(d_0=-2.0, t_0=0.01)
    d_2 = record(rope_snap.model, p, np.arange(400))
    assert not d_2[:200].any()
    assert np.all(d_2[200:] == -2.0)


def test_slotting_force_acts_within_the_cut_with_its_two_lines() -> None:
    p = slotting_force.Parameters()
    k = np.arange(30_000)
    d_2 = record(slotting_force.model, p, k)
    t, cut = k * T_s, (k >= 12_000) & (k < 24_000)
    assert not d_2[~cut].any()
    spindle, tooth = (2 * np.pi * f * t for f in (3500 / 60, 4 * 3500 / 60))
    expected = -(0.25 + 0.02 * np.sin(spindle) + 0.01 * np.sin(tooth))
    assert d_2[cut] == pytest.approx(expected[cut], abs=1e-11)


@given(st.floats(0.01, 9_999), st.integers(0, 2**27))
def test_a_sine_keeps_its_phase_however_long_it_runs(f_hz: float, k: int) -> None:
    turns = Fraction(f_hz * T_s) * k  # of the frequency as rounded to a double
    phase = 2 * np.pi * float(turns - int(turns))
    assert sine(f_hz, float(k), T_s) == pytest.approx(np.sin(phase), abs=5e-15)


def test_excitation_starts_at_phase_zero_after_its_rest() -> None:
    p = excitation.Parameters(A=3.0, f_hz=50.0, t_0=0.1)
    d = record(excitation.model, p, np.arange(4000))
    assert not d[:2001].any()
    t = T_s * np.arange(2000)
    assert d[2000:] == pytest.approx(3 * np.sin(2 * np.pi * 50 * t), abs=1e-11)


def test_a_chirp_sweeps_from_its_first_to_its_last_frequency_and_again() -> None:
    p = chirp.Parameters(F=50.0, f_0_hz=20.0, c=190.0, T=1.0, t_0=0.1)
    f = record(chirp.model, p, np.arange(42_000))
    t = T_s * np.arange(20_000)
    assert not f[:2001].any()
    assert np.array_equal(f[22_000:42_000], f[2000:22_000])
    phase = np.unwrap(np.arcsin(f[2000:2200] / 50.0), period=np.pi)
    assert phase[:100] == pytest.approx(
        2 * np.pi * (20 * t + 190 * t * t)[:100], abs=1e-9
    )
    crossings = np.count_nonzero(np.diff(np.sign(f[2001:22_000])))
    assert crossings == 2 * (20 + 190) - 1
