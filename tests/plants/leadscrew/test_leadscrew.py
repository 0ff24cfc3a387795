"""The leadscrew: friction, limits and the accuracy of its own integration rule."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmus.model import pack, unpack
from plants.leadscrew import axis as leadscrew
from plants.leadscrew._lugre import bristle, slip
from plants.leadscrew.axis import Input, Parameters, State, advance, current, derivative

HEAVY = Parameters(M=17.5, T_c=0.09, C_sd=1e-3, K_n=3.34e7, C_n=9200.0)


def moved(x: State, u: float, p: Parameters, h: float, n: int) -> State:
    """Return the state after n micro-steps of h at the command u."""
    for _ in range(n):
        x = advance(x, Input(u), p, h)
    return x


def integrated(x: State, currents: Sequence[float], p: Parameters, t: float) -> State:
    """Return the state by SciPy after each current was held for t."""
    vector = pack(x)
    for u in currents:

        def rhs(_: float, vector: np.ndarray, u: float = u) -> np.ndarray:
            return pack(derivative(unpack(State(), vector), Input(u), p))

        found = solve_ivp(rhs, (0, t), vector, "DOP853", rtol=1e-12, atol=1e-20)
        vector = found.y[:, -1]
    return unpack(State(), vector)


@pytest.mark.parametrize("p", [Parameters(), HEAVY])
@pytest.mark.parametrize(
    "currents", [[0.1], [0.4, -0.4, 0.3, -0.2]], ids=["one way", "with reversals"]
)
def test_the_rule_converges_to_the_differential_equations_with_fourth_order(
    p: Parameters, currents: list[float]
) -> None:
    exact = integrated(State(), currents, p, 4e-3)
    errors = []
    for n in (50, 100, 200):
        x = State()
        for u in currents:
            x = moved(x, u, p, 4e-3 / n, n)
        errors.append(abs(x.omega - exact.omega))
    assert abs(x.x - exact.x) < 1e-14  # m: 1e-5 of a step of the sensor, at 20 us
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.2)


def test_braking_through_a_reversal_agrees_with_an_independent_integrator() -> None:
    p = Parameters()
    start = State(omega=3.0, v=3.0 * 2e-3 / (2 * np.pi), z=p.T_c / p.sigma_0)
    exact = integrated(start, [-0.5], p, 8e-3)
    found = moved(start, -0.5, p, 1e-5, 800)
    assert exact.omega < 0
    assert found.x == pytest.approx(exact.x, rel=1e-9)
    assert found.omega == pytest.approx(exact.omega, rel=1e-7)


@given(
    z=st.floats(-1, 1),
    omega=st.floats(-500, 500),
    h=st.floats(1e-7, 1e-4),
    T_c=st.floats(1e-3, 1.0),
)
def test_the_bristle_never_carries_more_than_coulomb_friction(
    z: float, omega: float, h: float, T_c: float
) -> None:
    limit = T_c / 107.0
    after = bristle(z * limit, omega * h, T_c, 107.0)
    assert abs(after) <= limit * (1 + 1e-12)


def test_the_bristle_follows_its_equation_exactly() -> None:
    z, omega, T_c, sigma_0 = -2e-4, 0.7, 0.046, 107.0

    def rhs(_: float, z: np.ndarray) -> np.ndarray:
        return np.array(slip(z, omega, T_c, sigma_0) * omega)

    exact = solve_ivp(rhs, (0, 1e-3), [z], rtol=1e-12, atol=1e-18).y[0, -1]
    assert bristle(z, omega * 1e-3, T_c, sigma_0) == pytest.approx(exact, rel=1e-9)


def test_without_friction_nothing_brakes_and_nothing_is_undefined() -> None:
    p = Parameters(T_c=0.0, C_sd=0.0)
    x = moved(State(omega=10.0, v=10.0 * 2e-3 / (2 * np.pi)), 0.0, p, 5e-5, 400)
    assert x.omega == pytest.approx(10.0, rel=1e-9)
    assert x.z == 0.0


def test_a_slowly_rising_torque_deflects_the_bristle_along_its_virgin_curve() -> None:
    p = Parameters(C_sd=0.0, sigma_1=0.05)
    x = State()
    for k in range(8000):
        x = advance(x, Input(0.2 * (k + 1) / 8000), p, 5e-5)
    load = p.K_m * 0.2 / p.T_c
    virgin = -p.T_c / p.sigma_0 * np.log(1 - load)
    assert x.theta == pytest.approx(virgin, rel=5e-3)
    assert x.x == pytest.approx(virgin * p.lead / (2 * np.pi), rel=5e-3)


@pytest.mark.parametrize("way", [1, -1])
def test_the_supply_voltage_limits_the_speed(way: int) -> None:
    p = Parameters()
    running = State(omega=way * 390.0, v=way * 390.0 * p.lead / (2 * np.pi))
    x = moved(running, way * 6.0, p, 5e-5, 8000)
    i = current(way * 6.0, x.omega, p)
    assert abs(i) < 3.0
    assert p.K_e * x.omega + p.R * i == pytest.approx(way * p.V, rel=1e-9)
    assert p.K_m * i == pytest.approx(way * p.T_c + p.C_sd * x.omega, rel=1e-3)


def test_meeting_the_voltage_limit_within_a_step_costs_no_accuracy() -> None:
    p = Parameters(R=8.08)
    exact = integrated(State(), [5.0], p, 2e-2)
    found = moved(State(), 5.0, p, 1e-5, 2000)
    assert p.K_e * exact.omega + p.R * 5.0 > p.V
    assert found.x == pytest.approx(exact.x, rel=0, abs=1e-14)


def test_the_current_is_limited_before_the_voltage_at_rest() -> None:
    assert current(9.0, 0.0, Parameters()) == 6.0
    assert current(-9.0, 0.0, Parameters()) == -6.0
    # braking against the back-EMF stays within the amplifier's limit
    assert current(-9.0, 400.0, Parameters()) == -6.0


def test_the_model_takes_the_rule_not_runge_kutta() -> None:
    assert leadscrew.model.advance is advance
