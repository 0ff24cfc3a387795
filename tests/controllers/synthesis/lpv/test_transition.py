"""Polynomials of smooth switching (Hanifzadegan 2014, sec. 6.2)."""

import numpy as np
import pytest

from controllers.synthesis.lpv.transition import coefficients, share, slope


def test_the_quintic_is_the_published_one() -> None:
    """In θ of the serial machine, 0.38 to 0.42 m, its factors are printed."""
    assert coefficients() == pytest.approx([0, 0, 0, 10, -15, 6, 0], abs=1e-9)
    assert [share(s) for s in (0.1, 0.25, 0.5)] == pytest.approx(
        [0.00856, 0.103515625, 0.5]
    )
    s = np.polynomial.Polynomial([-0.38 / 0.04, 1 / 0.04])
    in_metres = sum(a * s**k for k, a in enumerate(coefficients()))
    printed = [-595018.25, 7462546.875, -37406250, 93671875, -117187500, 58593750]
    assert in_metres.coef[:6] == pytest.approx(printed, rel=1e-9)


@pytest.mark.parametrize("c", [0.0, 1.0, -5.0])
def test_two_derivatives_vanish_at_either_end(c: float) -> None:
    alpha = np.polynomial.Polynomial(coefficients(c))
    for order in (1, 2):
        assert alpha.deriv(order)(np.array([0.0, 1.0])) == pytest.approx(
            [0, 0], abs=1e-9
        )
    assert [share(-1.0, c), share(2.0, c)] == [0.0, 1.0]
    assert slope(1.5, c) == 0.0


def test_the_free_number_never_lowers_the_largest_slope() -> None:
    s = np.linspace(0, 1, 2001)
    peaks = {c: max(slope(x, c) for x in s) for c in (0.0, 1.0, -1.0, 5.0)}
    assert peaks[0.0] == pytest.approx(1.875, abs=1e-6)
    assert peaks[1.0] == pytest.approx(1.87734, abs=1e-5)
    assert peaks[5.0] == pytest.approx(1.93072, abs=1e-5)
    assert min(peaks, key=lambda c: peaks[c]) == 0.0
