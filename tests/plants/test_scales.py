"""Scales: exact positions without errors, rated errors, noise of its size and seed."""

import numpy as np
import pytest

from plants._scale import Scale
from plants.ball_screw import encoder, scales
from plants.gantry import encoder as gantry_encoder
from plants.gantry import scales as gantry_scales

CLEAN = Scale(0.0, 4e-6, 0.0)
R_G = scales.Parameters().r_g


@pytest.mark.parametrize("x", [0.0, 1.234e-3, -7.7e-2])
def test_without_errors_they_are_the_encoders(x: float) -> None:
    p = scales.Parameters(rotary=CLEAN, linear=CLEAN)
    u = encoder.Input(x, x / 3)
    _, found = scales.step(scales.State(5.0), u, p, 5e-5)
    _, plain = encoder.step(encoder.State(), u, encoder.Parameters(on=True), 5e-5)
    assert found == plain
    p_g = gantry_scales.Parameters(scale=CLEAN)
    u_g = gantry_encoder.Input(x, x / 3, -x)
    _, at = gantry_scales.step(gantry_scales.State(5.0), u_g, p_g, 5e-5)
    on = gantry_encoder.Parameters(on=True)
    assert at == gantry_encoder.step(gantry_encoder.State(), u_g, on, 5e-5)[1]


def test_the_interpolation_error_has_its_amplitude_and_its_period() -> None:
    p = scales.Parameters(on=False)
    metres = np.linspace(0, 12e-6, 1201)
    u = encoder.Input(metres / R_G, metres / R_G)
    _, y = scales.step(scales.State(), u, p, 5e-5)
    errors = [(y.y_1 - u.x_1) * R_G, (y.y_2 - u.x_2) * R_G]
    wave = np.sin(2 * np.pi * metres / 4e-6)
    expected = np.array([200e-9 * wave, 40e-9 * wave])
    assert np.array(errors) == pytest.approx(expected, abs=1e-16)


def test_noises_of_the_axes_are_independent_and_repeat_by_their_seed() -> None:
    p = gantry_scales.Parameters(scale=Scale(0.0, 4e-6, 2e-9), on=False)

    ticks = np.arange(4000.0)

    def readings(seed: float) -> np.ndarray:
        of = p._replace(noise=p.noise._replace(seed=seed))
        u = gantry_encoder.Input()
        _, y = gantry_scales.step(gantry_scales.State(ticks), u, of, 1e-4)
        return np.transpose(y)

    first = readings(1.0)
    assert np.std(first, axis=0) == pytest.approx([2e-9] * 3, rel=0.05)
    apart = np.corrcoef(np.transpose([*first.T, *readings(2.0).T]), rowvar=False)
    assert np.max(np.abs(apart - np.eye(6))) < 0.08
    assert np.array_equal(first, readings(1.0))
