"""A mechanism that warms up: without it the axis, with it less friction."""

import numpy as np
import pytest

from plants.leadscrew import axis, warming


def test_cold_and_insensitive_it_is_the_axis() -> None:
    p = warming.Parameters(a_c=0.0, a_v=0.0)
    x, y = warming.State(), axis.State()
    for k in range(100):
        u = axis.Input(2.0 * np.sin(0.1 * k))
        x = warming.advance(x, u, p, 1e-5)
        y = axis.advance(y, u, p.screw, 1e-5)
    assert tuple(x.screw) == tuple(y)
    assert x.warmth > 0


def test_at_rest_it_cools_and_warm_friction_is_less() -> None:
    p = warming.Parameters(a_c=0.1, a_v=0.2, tau=2.0)
    x = warming.State(warmth=1.0)
    for _ in range(100):
        x = warming.advance(x, axis.Input(), p, 1e-2)
    assert x.warmth == pytest.approx(np.exp(-0.5), rel=2e-3)
    now = warming.output(x, axis.Input(), p)
    assert now.T_c_now == pytest.approx(0.046 * (1 - 0.1 * x.warmth))
    assert now.C_sd_now == pytest.approx(9.7e-4 * (1 - 0.2 * x.warmth))


def test_the_power_of_p_1_makes_it_one() -> None:
    p = warming.Parameters(a_c=0.0, a_v=0.0, P_1=5.0, tau=1.0)
    omega = 100.0
    z = p.screw.T_c / p.screw.sigma_0  # sliding
    x = warming.State(axis.State(omega=omega, z=z), warmth=1.0)
    power = (p.screw.T_c + p.screw.C_sd * omega) * omega
    assert warming.heating(x, p) == pytest.approx(power / 5.0 - 1.0)
