"""The table's loops against the printed equations and independent figures."""

import numpy as np
import pytest

from controllers.synthesis.popov import popov
from controllers.synthesis.xy_table.loops import (
    Cascade,
    figures,
    gain_for_error,
    largest_gain,
    quasi_static_error,
    tracking_error,
)

OMEGA = np.geomspace(0.1, 1e4, 200)


def printed(omega: np.ndarray, fc_hz: float | None = None) -> dict[str, np.ndarray]:
    """Return eq. 1 to 3 as printed."""
    s = 1j * omega
    G = 78020 * np.exp(-0.0012 * s) / (s**2 + 163 * s + 193.3)
    PI = 0.006607 + 0.12075 / s
    V_est = s if fc_hz is None else s / (1 + s / (2 * np.pi * fc_hz))
    speed = PI * G * V_est
    return {"G": G, "speed": speed, "position": 225 * PI * G / (1 + speed)}


@pytest.mark.parametrize("fc_hz", [None, 300.0])
def test_the_traced_loops_are_the_printed_equations(fc_hz: float | None) -> None:
    filtered = {"estimator.filtered": True, "estimator.omega_c_hz": fc_hz}
    loops = Cascade(**(filtered if fc_hz else {})).loops(OMEGA)
    for name, expected in printed(OMEGA, fc_hz).items():
        np.testing.assert_allclose(getattr(loops, name), expected, rtol=1e-11)


def test_margins_and_popov_figures_are_those_computed_independently() -> None:
    found = figures()
    expected = {
        "speed_gain_margin": (8.70, 0.01),
        "speed_phase_crossover": (1395, 0.5),
        "speed_phase_margin": (72.6, 0.05),
        "speed_gain_crossover": (489.8, 0.1),
        "position_gain_margin": (11.62, 0.01),
        "position_phase_crossover": (760.35, 0.01),
        "position_phase_margin": (70.5, 0.05),
        "position_gain_crossover": (177.8, 0.1),
        "popov_crossing": (-0.2623, 0.0003),
        "popov_omega": (760.35, 0.01),
        "popov_K": (0.70, 0.005),
        "popov_q": (0.0094, 0.0001),
        "popov_shifted_K": (3.8128, 0.0002),
        "popov_shifted_q": (6.7e-4, 1e-5),
        "circle_shifted_K": (3.537, 0.001),
    }
    for name, (value, tolerance) in expected.items():
        assert found[name] == pytest.approx(value, abs=tolerance), name
    assert found["K_max"] * found["popov_crossing"] == pytest.approx(-1)


def test_popov_certifies_the_sector_of_cosh_up_to_the_linear_limit() -> None:
    cascade = Cascade()
    fine = np.geomspace(1, 1e5, 100_003)
    limit, q = popov(cascade.position, 1.0)
    L = printed(fine)["position"]
    line = np.min((L / (1 + L) * (1 + 1j * fine * q)).real)
    assert 1 - 1 / line == pytest.approx(limit, rel=1e-5)


@pytest.mark.parametrize(
    ("fc_hz", "speed", "position"),
    [
        (200, (6.96, 55.9), (6.44, 75.8)),
        (500, (7.41, 64.5), (9.49, 72.7)),
        (1000, (7.88, 68.3), (10.60, 71.6)),
    ],
)
def test_no_velocity_filter_reaches_the_published_margins(
    fc_hz: float, speed: tuple[float, float], position: tuple[float, float]
) -> None:
    cascade = Cascade(**{"estimator.filtered": True, "estimator.omega_c_hz": fc_hz})
    batteries = cascade.speed_battery(), cascade.position_battery()
    for found, (gain, phase) in zip(batteries, (speed, position), strict=True):
        gain_margin = 20 * np.log10(found.gain_margins.min())
        assert gain_margin == pytest.approx(gain, abs=0.01)
        phase_margin = np.rad2deg(found.phase_margins.min())
        assert phase_margin == pytest.approx(phase, abs=0.06)
    # 9.31 dB with 56.4 degrees: the filter only takes gain margin away
    assert batteries[0].gain_margins.min() < 10 ** (8.71 / 20)


@pytest.mark.parametrize(("f_hz", "error"), [(0.4, 0.11465), (0.7, 0.20287)])
def test_the_steady_error_is_that_of_equation_8(f_hz: float, error: float) -> None:
    loops = printed(np.array([2 * np.pi * f_hz]))
    ratio = (1 + loops["speed"]) / (1 + loops["speed"] + 225 * velocity_gain(f_hz))
    assert tracking_error(f_hz) == pytest.approx(10 * abs(ratio[0]), rel=1e-12)
    assert tracking_error(f_hz) == pytest.approx(error, abs=5e-6)


def velocity_gain(f_hz: float) -> np.ndarray:
    s = np.array([2j * np.pi * f_hz])
    return np.asarray((0.006607 + 0.12075 / s) * printed(s.imag)["G"])


@pytest.mark.parametrize(
    ("f_hz", "KO", "error"),
    [
        (0.4, 3.5, 0.10705),
        (0.7, 3.5, 0.17118),
        (0.4, 4.0, 0.10520),
        (0.7, 4.0, 0.16534),
    ],
)
def test_the_quasi_static_error_repeats_itself(
    f_hz: float, KO: float, error: float
) -> None:
    e = quasi_static_error(f_hz, KO=KO)
    assert e == pytest.approx(error, abs=1e-5)
    assert tracking_error(f_hz, N=float(np.cosh(KO * e))) == pytest.approx(e, rel=1e-12)


def test_the_published_theoretical_errors_need_a_gain_of_no_stated_origin() -> None:
    assert gain_for_error(0.4, 0.0925) == pytest.approx(1.239, abs=5e-4)
    assert gain_for_error(0.7, 0.1640) == pytest.approx(1.237, abs=5e-4)
    # "K_e = 0.8" of section 4 is K_e2 - K_e1; neither it nor 1.8 gives table 2
    assert largest_gain(4.0) - largest_gain(3.5) == pytest.approx(0.798, abs=5e-4)
    assert tracking_error(0.4, N=0.8) == pytest.approx(0.1433, abs=5e-5)
    assert tracking_error(0.4, N=1.8) == pytest.approx(0.0637, abs=5e-5)


def test_an_unknown_parameter_is_refused() -> None:
    with pytest.raises(LookupError, match="k_x"):
        figures(k_x=1.0)
