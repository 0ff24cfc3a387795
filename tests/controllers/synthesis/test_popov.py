"""Popov's criterion and its relatives on loops with textbook answers."""

import numpy as np
import pytest

from controllers.synthesis.popov import crossing, popov, shifted
from fmus.model import FloatArray


def triple(omega: FloatArray) -> np.ndarray:
    """1/(s + 1)³: crosses the axis at -1/8, ω = √3."""
    return np.asarray(1 / (1 + 1j * omega) ** 3)


def double(omega: FloatArray) -> np.ndarray:
    """1/(s + 1)²: min Re = -1/8 at ω = √3, never crosses the axis."""
    return np.asarray(1 / (1 + 1j * omega) ** 2)


def late_integrator(omega: FloatArray) -> np.ndarray:
    """exp(-s)/s: crosses at ω = π/2, 5π/2, ..., first at -2/π."""
    return np.asarray(np.exp(-1j * omega) / (1j * omega))


def test_the_crossing_of_a_triple_lag_is_at_minus_an_eighth() -> None:
    assert crossing(triple) == pytest.approx((-1 / 8, np.sqrt(3)), rel=1e-10)


def test_of_many_crossings_the_leftmost_counts() -> None:
    grid = np.linspace(0.1, 100, 5000)
    assert crossing(late_integrator, grid) == pytest.approx((-2 / np.pi, np.pi / 2))


def test_a_locus_without_crossing_is_refused() -> None:
    with pytest.raises(ValueError, match="does not cross"):
        crossing(double)


def test_popov_certifies_the_linear_limit_of_a_triple_lag() -> None:
    assert pytest.approx(8, rel=1e-5) == popov(triple).K


def test_popov_sets_no_limit_to_a_double_lag_where_the_circle_does() -> None:
    assert np.inf == popov(double).K
    circle = popov(double, q=0.0)
    assert circle == pytest.approx((8, 0), rel=1e-6)


@pytest.mark.parametrize("a", [0.5, 1.0, 4.0])
def test_a_closed_gain_moves_the_crossing_by_itself(a: float) -> None:
    at = crossing(shifted(triple, a))
    assert a - 1 / at.re == pytest.approx(8, rel=1e-9)
    assert at.omega == pytest.approx(np.sqrt(3), rel=1e-9)


@pytest.mark.parametrize("a", [0.0, 2.0])
def test_the_certified_sector_is_the_largest_of_any_slope(a: float) -> None:
    omega = np.geomspace(1e-2, 1e3, 4001)
    sector = popov(late_resonance, a, omega)
    G = shifted(late_resonance, a)(omega)

    def certified(q: float) -> float:
        return float(a - 1 / np.min((G * (1 + 1j * omega * q)).real))

    assert certified(sector.q) == pytest.approx(sector.K, rel=1e-7)
    for q in sector.q + np.geomspace(1e-4, 10, 40):
        assert certified(q) <= sector.K * (1 + 1e-9)
    for q in np.linspace(0, sector.q, 40):
        assert certified(q) <= sector.K * (1 + 1e-9)


def late_resonance(omega: FloatArray) -> np.ndarray:
    s = 1j * omega
    return np.asarray(0.05 * np.exp(-0.05 * s) * (1 + s) / (s**2 + 0.2 * s + 1))
