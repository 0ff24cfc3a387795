"""The low-pass beside the notch, braking by a D controller, gain by bisection."""

import numpy as np
import pytest

from controllers.leadscrew import conditional_low_pass, d_braking, gain_bisection

T_S = 2e-4


@pytest.mark.parametrize("zeta", [0.5, 1.0, 3.0, 6.0])
def test_the_gain_at_its_frequency_is_half_over_zeta(zeta: float) -> None:
    p = conditional_low_pass.Parameters(on=True, zeta=zeta, e_n=1.0)
    d = conditional_low_pass.prepare(p, T_S)
    z = np.exp(-2j * np.pi * 215.0 * T_S)
    G = (d.b_0 + d.b_1 * z + d.b_2 * z * z) / (1 + d.a_1 * z + d.a_2 * z * z)
    assert abs(G) == pytest.approx(1 / (2 * zeta), rel=1e-9)
    assert (d.b_0 + d.b_1 + d.b_2) / (1 + d.a_1 + d.a_2) == pytest.approx(1.0)


def test_it_passes_what_is_outside_the_range_and_comes_in_without_a_bump() -> None:
    p = conditional_low_pass.Parameters(on=True)
    d = conditional_low_pass.prepare(p, T_S)
    x = conditional_low_pass.State()
    for e in (1e-3, 1e-3, 1e-4, 1e-5):
        x, y = conditional_low_pass.step(
            x, conditional_low_pass.Input(2.5, e), p, T_S, d
        )
        assert y.u_f == pytest.approx(2.5)


def test_the_d_controller_brakes_by_the_speed_after_the_pulse() -> None:
    p = d_braking.Parameters(u_r=6.0, t_r=3 * T_S, K_d=0.05)
    x, currents = d_braking.State(), []
    for position in (0.0, 0.01, 0.03, 0.06, 0.09, 0.11):
        x, y = d_braking.step(x, d_braking.Input(position), p, T_S)
        currents.append(float(y.u))
    assert currents[:3] == [6.0, 6.0, 6.0]
    assert currents[4] == pytest.approx(-0.05 * 0.03 / T_S)
    assert currents[5] == pytest.approx(-0.05 * 0.02 / T_S)


def test_the_interval_halves_to_the_side_of_the_oscillation() -> None:
    """A reading that swings where K_p > 2 makes the current span more."""
    p = gain_bisection.Parameters(
        K_low=1.0, K_high=4.0, T_d=0.02, T_r=0.004, T_t=0.004, span=0.5
    )
    x, k = gain_bisection.State(), 0
    for _ in range(8):
        for _ in range(100):
            swing = 1e-4 * (-1) ** k if x.k > 20 and _gain(x, p) > 2.0 else 0.0
            u = gain_bisection.Input(x=swing)
            x, y = gain_bisection.step(x, u, p, T_S)
            k += 1
            if x.k and x.k <= 20:
                assert y.u == 0
    assert x.low <= 2.0 <= x.high
    assert x.high / x.low == pytest.approx(4 ** (2**-8))


def _gain(x: gain_bisection.State, p: gain_bisection.Parameters) -> float:
    low, high = x.low or p.K_low, x.high or p.K_high
    return float(np.sqrt(low * high))
