"""The calculator meets its specifications, whatever the plant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.synthesis.gantry.design import (
    added_damping,
    averaging,
    drive_lag,
    pid,
    x_axis,
    x_calculator,
)
from controllers.synthesis.loop_shaping import integrator_time, lead_ratio, shape
from plants.gantry import frame as gantry


@given(
    f_c=st.floats(1, 500),
    margin=st.floats(20, 60),
    lag=st.floats(-20, -2),
    phase=st.floats(-300, -185),
    size=st.floats(1e-9, 1e3),
)
def test_the_shaped_loop_has_its_crossover_and_margin(f_c, margin, lag, phase, size):
    omega = 2 * np.pi * f_c
    P = size * np.exp(1j * np.deg2rad(phase))
    found = shape(P, omega, np.deg2rad(margin), np.deg2rad(lag))
    s = 1j * omega
    lead = (found.T_d * s + 1) / (s / found.a + 1)
    L = P * found.K * (found.T_i * s + 1) / s * lead**found.leads
    assert abs(L) == pytest.approx(1)
    assert np.mod(np.angle(L, deg=True), 360) == pytest.approx(180 + margin)
    assert found.phi < np.pi / 2


def test_the_fewest_leads_that_suffice_are_taken():
    # 126 degrees are more than one lead gives (eq. 4.17)
    P = np.exp(1j * np.deg2rad(-261))
    found = shape(P, 1.0, np.deg2rad(35), np.deg2rad(-10))
    assert found.leads == 2
    assert np.rad2deg(found.phi) == pytest.approx(63)
    assert found.gamma == pytest.approx(4.1653, abs=1e-4)


def test_more_phase_than_the_leads_give_is_refused():
    P = np.exp(1j * np.deg2rad(-261))
    with pytest.raises(ValueError, match="take more leads"):
        shape(P, 1.0, np.deg2rad(35), np.deg2rad(-10), leads=1)
    with pytest.raises(ValueError, match="0 to 90"):
        lead_ratio(-0.1)


def test_the_integrator_lags_by_what_was_asked():
    T_i = integrator_time(2 * np.pi * 130, np.deg2rad(-10))
    assert T_i == pytest.approx(6.9432e-3, rel=1e-5)
    s = 2j * np.pi * 130
    assert np.angle((T_i * s + 1) / s, deg=True) == pytest.approx(-10)


def test_the_lag_that_explains_the_published_lead_asks_for_it_again():
    lag = drive_lag()
    assert lag["residual"] == pytest.approx(30.434, abs=1e-3)
    assert lag["delay"] == pytest.approx(0.6503e-3, rel=1e-4)
    found = x_calculator(m_x=0.6977, omega_l_hz=lag["omega_l_hz"])
    assert found["phi_lead"] == pytest.approx(126)
    assert found["K"] == pytest.approx(6.3453e6, rel=2e-5)
    ideal = x_axis(m_x=0.6977, lead_deg=126.0)
    assert ideal["K"] == pytest.approx(5.4710e6, rel=1e-5)


def test_designs_of_the_y_axis_are_those_of_the_study():
    p = gantry.Parameters()
    found = averaging(p.m, p.m_x, p.L, p.J_0, p.d, p.c, p.k)
    assert found["K"] == pytest.approx(1.16159e5, rel=1e-5)
    assert found["T_d"] == pytest.approx(4.7097e-3, rel=1e-5)
    assert found["a"] == pytest.approx(669.35, rel=1e-5)
    assert found["beta"] == pytest.approx(49.0355, rel=1e-6)
    assert added_damping(found["beta"]) == pytest.approx(590)
    literal = averaging(p.m, p.m_x, p.L, p.J_0, p.d, p.c, p.k, effective=False)
    assert literal["beta"] == pytest.approx(100.112, rel=1e-5)
    baseline = pid(p.m)
    assert baseline == pytest.approx(
        {"K_p": 15869.0, "K_i": 247953.0, "K_d": 253.904}, rel=1e-6
    )
