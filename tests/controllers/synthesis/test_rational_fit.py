"""A stable fit finds stable modes, and makes unstable ones stable."""

import numpy as np
import pytest

from controllers.synthesis.rational_fit import Modes, stable_fit
from plants.three_axis import _axes, _values

OMEGA = 2 * np.pi * (5.0 + 5.0 * np.arange(91))
AXES = [(_axes.X, _values.X), (_axes.Y, _values.Y), (_axes.Z, _values.Z)]


def printed(axis: _axes.Axis) -> np.ndarray:
    s = 1j * OMEGA
    return np.asarray(np.polyval(axis.numerator, s) / np.polyval(axis.denominator, s))


@pytest.mark.parametrize(("source", "known"), AXES)
def test_modes_are_those_behind_the_response(source, known) -> None:
    """Order 5, 6 and 11 with poles from 80 to 2363 rad/s (Table 8.2)."""
    found = stable_fit(OMEGA, printed(source), len(source.denominator) - 1)
    assert found.sigma == pytest.approx(known.sigma, rel=1e-5)
    assert found.omega == pytest.approx(known.omega, rel=1e-5, abs=1e-6)
    assert found.c == pytest.approx(known.c, rel=1e-4)


def test_noise_of_one_percent_moves_the_modes_by_little() -> None:
    draw = np.random.default_rng(1)
    noise = draw.normal(size=(2, len(OMEGA))) * 0.01 / np.sqrt(2)
    H = printed(_axes.X) * (1 + noise[0] + 1j * noise[1])
    found = stable_fit(OMEGA, H, 6)
    assert found.omega[::2] == pytest.approx(_values.X.omega[::2], rel=0.02)
    assert np.all(found.sigma < 0)


def test_a_response_of_unstable_poles_gets_stable_ones() -> None:
    """As printed, the denominator of z has poles at 117.9 ± 2012j."""
    unstable = Modes(
        np.array([-30.0, -30.0, 40.0, 40.0]),
        np.array([500.0, 0.0, 1800.0]),
        np.array([1.0, 0.0, 1.0, 0.0]),
        np.array([100.0, 5.0, 30.0, 2.0]),
    )
    found = stable_fit(OMEGA, unstable.response(OMEGA), 4)
    assert np.all(found.sigma < 0)
    assert found.omega[0] == pytest.approx(500, rel=0.05)


def test_too_few_points_are_refused() -> None:
    with pytest.raises(ValueError, match="do not determine"):
        stable_fit(OMEGA[:3], printed(_axes.X)[:3], 6)
