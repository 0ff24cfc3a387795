"""The H1 estimate and the fit of a drive with dead time, on data of known drives."""

import numpy as np
import pytest

from controllers.synthesis.frf_estimate import h1, identify
from orchestrator.session import run
from plants.xy_table import axis

T_S = 1 / 2000


def test_h1_finds_a_filter_under_noise_in_the_output() -> None:
    generator = np.random.default_rng(1)
    u = generator.normal(size=200_000)
    clean = np.convolve(u, [0.5, 0.3, 0.2])[: len(u)]
    y = clean + generator.normal(scale=0.5, size=len(u))
    found = h1(u, y, T_S, 5.0)
    z = np.exp(-2j * np.pi * found.f_hz * T_S)
    exact = 0.5 + 0.3 * z + 0.2 * z**2
    # noise of half the input's size, averaged over all segments: 0.5 / sqrt(n)
    spread = np.std(np.abs(found.G - exact))
    assert spread < 0.5 / np.sqrt(found.segments)
    assert np.all(found.coherence < 1)


def test_a_record_that_is_too_short_is_refused() -> None:
    with pytest.raises(ValueError, match="longer record"):
        h1(np.ones(1000), np.ones(1000), T_S, 1.0)
    with pytest.raises(ValueError, match="8 lines"):
        identify(np.ones(20_000), np.ones(20_000), T_S, 2.0, 10.0, 20.0)


def test_the_drive_of_the_xy_table_is_recovered_from_a_noisy_run() -> None:
    done = run("cascade_nppi/identification", report=False)
    u, y = done["source.d"].values, done["sensor.y"].values
    found = identify(u, y, T_S, 0.5, 1.0, 200.0, 1e3)
    p = axis.model.parameters
    assert found["b"] == pytest.approx(p.b, rel=0.002)
    assert found["a_1"] == pytest.approx(p.a_1, rel=0.005)
    assert found["tau"] == pytest.approx(p.tau, abs=5e-6)
    # its pole of 0.19 Hz lies below the lines
    assert found["a_0"] == pytest.approx(p.a_0, rel=0.2)
