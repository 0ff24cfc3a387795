"""NCTF control: its parts, the freeze, the notch, and PI-D."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.leadscrew import compensator as nct_compensator
from controllers.leadscrew import conditional_notch, nctf, pi_d
from controllers.leadscrew import nominal_trajectory as nct_element
from controllers.leadscrew._frozen_integral import integrated
from controllers.leadscrew.nominal_trajectory import POINTS, Input

T_s = 2e-4
TABLE = {
    "e_nct": np.append(0.0, np.geomspace(1e-3, 20.0, POINTS - 1)),
    "edot_nct": 16 * np.sqrt(np.append(0.0, np.geomspace(1e-3, 20.0, POINTS - 1))),
}
MOTION = st.lists(
    st.tuples(st.floats(-1, 1), st.floats(-9, 9)), min_size=1, max_size=30
)


@given(MOTION)
def test_the_whole_controller_is_its_parts_in_order(
    motion: list[tuple[float, float]],
) -> None:
    p = nctf.Parameters(
        **TABLE, continuous=True, notch=conditional_notch.Parameters(on=True, e_n=0.5)
    )
    d = nctf.prepare(p, T_s)
    x = nctf.State()
    element, compensator = nct_element.State(), nct_compensator.State()
    notch = conditional_notch.State()
    for position, v_r in motion:
        x, y = nctf.step(x, Input(0.3, v_r, position), p, T_s, d)
        element, a = nct_element.step(
            element,
            Input(0.3, v_r, position),
            nct_element.Parameters(**TABLE, continuous=True),
            T_s,
        )
        compensator, b = nct_compensator.step(
            compensator,
            nct_compensator.Input(a.u_p),
            nct_compensator.Parameters(),
            T_s,
        )
        notch, c = conditional_notch.step(
            notch, conditional_notch.Input(b.u, a.e), p.notch, T_s, d
        )
        assert (y.u, y.e, y.u_p) == (c.u_n, a.e, a.u_p)


@given(st.floats(0, 50))
def test_the_trajectory_is_odd_and_held_beyond_its_end(e: float) -> None:
    p = nct_element.Parameters(**TABLE)
    _, plus = nct_element.step(nct_element.State(), Input(x_r=e), p, T_s)
    _, minus = nct_element.step(nct_element.State(), Input(x_r=-e), p, T_s)
    wanted = np.interp(e, TABLE["e_nct"], TABLE["edot_nct"])
    assert plus.v_nct == pytest.approx(wanted, abs=1e-12)
    assert minus.v_nct == -plus.v_nct


def test_the_first_sample_has_no_rate() -> None:
    p = nct_element.Parameters(**TABLE)
    x, y = nct_element.step(nct_element.State(), Input(x_r=5.0, x=5.0), p, T_s)
    assert y.u_p == 0.0
    _, y = nct_element.step(x, Input(x_r=5.0, x=5.002), p, T_s)
    assert y.u_p == pytest.approx(y.v_nct - 10.0)


@pytest.mark.parametrize(
    ("u_i", "rate", "u_o", "moves"),
    [
        (5.0, 100.0, 2.0, False),  # saturated, pushed on
        (5.0, -100.0, 2.0, True),  # saturated, pulled back
        (5.0, 100.0, 0.5, True),  # not saturated
        (-5.0, -100.0, -2.0, False),
        (0.0, 100.0, 9.0, False),  # 3-16: zero counts as pushed on
        (1.0, 100.0, -9.0, False),  # 3-16 looks at u_i, not at the sum
    ],
)
def test_the_integral_freezes_as_equation_3_16_says(
    u_i: float, rate: float, u_o: float, moves: bool
) -> None:
    after = integrated(u_i, rate, u_o, 6.0, True, T_s)
    assert after == (u_i + T_s * rate if moves else u_i)
    assert integrated(u_i, rate, u_o, 6.0, False, T_s) == u_i + T_s * rate


def response(p: conditional_notch.Parameters, f_hz: float) -> complex:
    """Return the notch's frequency response at f_hz."""
    d = conditional_notch.prepare(p, T_s)
    z = np.exp(-2j * np.pi * f_hz * T_s)
    top, bottom = (d.b_0, d.b_1, d.b_2), (1.0, d.a_1, d.a_2)
    return complex(np.polyval(top[::-1], z) / np.polyval(bottom[::-1], z))


@pytest.mark.parametrize("zeta", [0.5, 1.0, 3.0, 6.0])
def test_the_notch_stops_its_frequency_and_passes_the_lowest(zeta: float) -> None:
    p = conditional_notch.Parameters(on=True, zeta=zeta)
    assert abs(response(p, 215.0)) < 1e-12
    assert response(p, 0.0) == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize(
    ("zeta", "published"), [(0.5, 135), (1, 89), (1.5, 64), (3, 34), (6, 17)]
)
def test_the_discrete_notch_has_the_cutoff_of_table_4_1(
    zeta: float, published: float
) -> None:
    p = conditional_notch.Parameters(on=True, zeta=zeta)
    analog = 215 * (np.sqrt(zeta**2 + 1) - zeta)
    assert analog == pytest.approx(published, abs=2.2)
    assert abs(response(p, analog)) == pytest.approx(np.sqrt(0.5), abs=4e-3)


def test_the_notch_comes_in_without_a_bump() -> None:
    p = conditional_notch.Parameters(on=True)
    d = conditional_notch.prepare(p, T_s)
    x = conditional_notch.State()
    for e in (1.0, 1.0, 1e-4, 1e-4, 1e-4):
        x, y = conditional_notch.step(x, conditional_notch.Input(2.5, e), p, T_s, d)
        assert y.u_n == pytest.approx(2.5, abs=1e-14)


def test_the_notch_passes_everything_outside_its_range_and_when_off() -> None:
    inside, outside = (
        conditional_notch.Input(1.0, 1e-4),
        conditional_notch.Input(1.0, 1.0),
    )
    for on, signal in ((True, outside), (False, inside)):
        p = conditional_notch.Parameters(on=on)
        d = conditional_notch.prepare(p, T_s)
        _, y = conditional_notch.step(conditional_notch.State(), signal, p, T_s, d)
        assert y.u_n == 1.0


def test_pi_d_and_nctf_are_the_same_law_on_a_straight_trajectory() -> None:
    """sec. 6.2: K_p = α K_pn + K_i, and the integral takes α e - ẋ."""
    alpha, K_p, K_i = 505.0, 0.98, 156.7
    table = {
        "e_nct": np.linspace(0, 1, POINTS),
        "edot_nct": alpha * np.linspace(0, 1, POINTS),
    }
    p = nctf.Parameters(**table, K_p=K_p, K_i=K_i, anti_windup=False)
    q = pi_d.Parameters(alpha * K_p + K_i, alpha * K_i, K_p, anti_windup=False)
    d = nctf.prepare(p, T_s)
    x, w = nctf.State(), pi_d.State()
    for k in range(200):
        signal = Input(1e-3, 0.0, 1e-3 * (1 - np.exp(-k / 40)))
        x, a = nctf.step(x, signal, p, T_s, d)
        w, b = pi_d.step(w, signal, q, T_s)
        # ∫ẋ = x - x_0, and the error began at 1e-3
        assert a.u == pytest.approx(b.u - K_i * 1e-3, abs=1e-9)
