"""Design of NCTF control: trajectory, gains, linear limits, friction tables."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from controllers.leadscrew import nominal_trajectory as nct_element
from controllers.leadscrew.nominal_trajectory import POINTS
from controllers.synthesis.jury import is_stable
from controllers.synthesis.leadscrew import friction_lookup
from controllers.synthesis.leadscrew.nct import gains, line, trajectory
from controllers.synthesis.leadscrew.stability import (
    closed_loop,
    linear_limit,
    practical_limit,
)
from controllers.synthesis.linearise import linearise
from plants.leadscrew import axis as leadscrew

T = 2e-4
a, c = 0.0809, 5.36  # Coulomb deceleration (m/s²) and viscous rate (1/s) of TAB


def coasting(v_0: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x, v of a run that coasts to rest from 0.1 s on: v̇ = -a - c v."""
    t = np.arange(0, 2.5, 1e-5)[: 2 * 125_000]
    since = np.maximum(t - 0.1, 0)
    stop = np.log1p(c * v_0 / a) / c
    s = np.minimum(since, stop)
    v = (v_0 + a / c) * np.exp(-c * s) - a / c
    x = np.where(t < 0.1, v_0 * (t - 0.1), 0) + (v_0 + a / c) * -np.expm1(-c * s) / c
    return x - a / c * s, np.where(since < stop, v, 0.0)


def test_the_trajectory_of_a_coasting_mass_is_the_analytic_one() -> None:
    x, v = coasting(0.12)
    table = trajectory(x, v, 1e-5, 0.1, 505.0)
    e, edot = table["e_nct"], table["edot_nct"]
    assert e.shape == edot.shape == (POINTS,)
    assert (e[0], edot[0]) == (0.0, 0.0)
    assert edot[1] == pytest.approx(505 * e[1], rel=1e-4)
    # e = (v - a/c ln(1 + c v/a)) / c, in mm
    V = edot[1:] / 1e3
    backbone = 1e3 * (V - a / c * np.log1p(c * V / a)) / c
    assert e[20:] == pytest.approx(backbone[19:], rel=2e-3)
    assert np.all(np.diff(e) > 0)


def test_a_line_that_does_not_meet_the_curve_is_refused() -> None:
    x, v = coasting(0.12)
    with pytest.raises(ValueError, match="does not meet"):
        trajectory(x, v, 1e-5, 0.1, 1.0)
    with pytest.raises(ValueError, match="decelerate"):
        trajectory(np.zeros(50), np.zeros(50), 1e-5, 1e-4, 505.0)


def test_the_gains_of_controller_1_follow_from_the_published_object() -> None:
    x = np.array([0.0, 48.5e-3])
    found = gains(x, T, 5.0, 0.3, 505.0, 5.0, 0.32)
    assert found["K_p"] == pytest.approx(0.981, rel=2e-3)
    assert found["K_i"] == pytest.approx(156.9, rel=2e-3)


def test_a_line_is_a_table_of_one_slope() -> None:
    table = line(505.0, 1.0)
    p = nct_element.Parameters(**table)
    _, y = nct_element.step(nct_element.State(), nct_element.Input(x_r=0.37), p, T)
    assert y.v_nct == pytest.approx(505 * 0.37, rel=1e-12)


@given(st.lists(st.floats(-2, 2), min_size=1, max_size=7))
def test_jury_agrees_with_the_roots(coefficients: list[float]) -> None:
    polynomial = np.array([1.0, *coefficients])
    largest = np.max(np.abs(np.roots(polynomial)), initial=0.0)
    if abs(largest - 1) > 1e-6:
        assert is_stable(polynomial) == (largest < 1)


def loop_poles(alpha: float, alpha_obj: float, wT: float, zeta: float) -> np.ndarray:
    """Poles of the loop from its parts in state space, nothing multiplied out."""
    K = 32.3
    K_p, K_i = 2 * zeta * wT / T / (alpha * K), (wT / T) ** 2 / (alpha * K)
    E = np.exp(-alpha_obj * T)
    # position and velocity under a held current
    A = np.array([[1, (1 - E) / alpha_obj], [0, E]])
    held = T / alpha_obj - (1 - E) / alpha_obj**2
    B = K * alpha * np.array([held, (1 - E) / alpha_obj])
    # states: x, v, delayed current, x_{k-1}, u_i
    u_p = np.array([-alpha - 1 / T, 0, 0, 1 / T, 0])
    u_i = np.array([0, 0, 0, 0, 1.0]) + K_i * T * u_p
    rows = np.zeros((5, 5))
    rows[:2, :2], rows[:2, 2] = A, B
    rows[2] = K_p * u_p + u_i
    rows[3, 0] = 1
    rows[4] = u_i
    return np.linalg.eigvals(rows)


@pytest.mark.parametrize("alpha_obj", [250.0, 505.0, 750.0])
@pytest.mark.parametrize(
    ("wT", "zeta"), [(0.02, 5.0), (0.1, 3.0), (0.32, 0.9), (0.4, 2)]
)
def test_the_corrected_equation_3_13_has_the_poles_of_the_loop(
    alpha_obj: float, wT: float, zeta: float
) -> None:
    polynomial = closed_loop(505 * T, wT, zeta, alpha_obj * T)
    roots = np.sort_complex(np.roots(polynomial))
    poles = np.sort_complex(loop_poles(505.0, alpha_obj, wT, zeta).astype(complex))
    assert roots == pytest.approx(poles, abs=1e-9)


def test_equation_3_12_as_printed_is_no_double_integrator_behind_a_lag() -> None:
    """(z + 1) for (z - 1): a current held for ever would not move the object on."""
    alpha, K, n = 505.0, 32.3, 40
    E = np.exp(-alpha * T)
    beta = alpha * T - 1 + E
    b = (1 - E - alpha * T * E) / beta
    top = beta * K / alpha * np.array([1, b])
    k = np.arange(n)
    exact = K * (k * T - (1 - np.exp(-alpha * k * T)) / alpha)

    def stepped(pole: float) -> np.ndarray:
        bottom = np.polymul([1, -pole], [1, -E])
        x = np.zeros(n)
        for i in range(1, n):
            u = top[0] + (top[1] if i > 1 else 0.0)
            x[i] = u - bottom[1] * x[i - 1] - (bottom[2] * x[i - 2] if i > 1 else 0.0)
        return x

    assert stepped(1.0) == pytest.approx(exact, rel=1e-9, abs=1e-12)
    assert abs(stepped(-1.0)[-1] - exact[-1]) > 0.5 * exact[-1]


@pytest.mark.parametrize(
    ("wT", "zeta"), [(0.02, 19.91), (0.1, 3.916), (0.2, 1.846), (0.32, 0.959)]
)
def test_the_linear_limits_are_known_ones(wT: float, zeta: float) -> None:
    assert linear_limit(wT) == pytest.approx(zeta, rel=5e-3)


def test_no_damping_ratio_is_stable_at_0_4() -> None:
    assert linear_limit(0.4) == 0.0
    assert linear_limit(0.4, alpha_obj_T=750 * T) > 0.6


def test_the_practical_limit_is_ten_times_the_linear_one() -> None:
    assert practical_limit(2.4, 0.1) == pytest.approx(39.1, abs=0.1)
    assert practical_limit(2.4, 0.1) > 9 * linear_limit(0.1)


def test_the_friction_free_mechanism_is_stable_up_to_a_gain_of_2_3() -> None:
    """Linear P-only loop at no delay, 2.30 A s/mm at 721 Hz."""
    p = leadscrew.Parameters(T_c=0.0)
    plant = linearise(leadscrew.model, parameters=p, inputs=["u"], outputs=["x"])
    keep = [i for i, n in enumerate(plant.state_labels) if n != "state.z"]
    M = np.zeros((5, 5))
    M[:4, :4], M[:4, 4] = plant.A[np.ix_(keep, keep)], plant.B[keep, 0]
    held = expm(M * T)
    A, B, C = held[:4, :4], held[:4, 4], 1e3 * plant.C[0, keep]

    def largest(K_p: float) -> float:
        # u = K_p (-α x - (x - x_1)/T), acting at once
        row = np.append(-K_p * (505 + 1 / T) * C, K_p / T)
        loop = np.zeros((5, 5))
        loop[:4, :4] = A
        loop[:4] += np.outer(B, row)
        loop[4, :4] = C
        return float(np.max(np.abs(np.linalg.eigvals(loop))))

    gains_tried = np.arange(1.5, 3.0, 0.005)
    stable = np.array([largest(K) < 1 for K in gains_tried])
    assert gains_tried[stable][-1] == pytest.approx(2.30, rel=0.01)


X = {
    "displacement": np.array(
        [17, 18.45541, 18.65233137322, 21.857963905, 23.18826, 25]
    ),
    "viscous": np.array([0.00105, 0.00103, 0.001, 0.0008, 0.00073, 0.0007]),
    "coulomb": np.array([0.11, 0.091, 0.09, 0.083, 0.078, 0.075]),
}


def test_friction_between_the_tabled_conditions_keeps_their_shape() -> None:
    found = friction_lookup.at_displacement(20.0, **X)
    assert found["C_sd"] == pytest.approx(8.965e-4, abs=1e-7)
    assert found["T_c"] == pytest.approx(0.08670, abs=1e-5)
    with pytest.raises(ValueError, match="outside"):
        friction_lookup.at_displacement(26.0, **X)


def test_friction_is_kept_when_the_mechanism_was_not_driven() -> None:
    x = np.full(100, 4.9e-3)
    x[0] = 0.0
    known = {"C_sd": 1.0, "T_c": 2.0}
    assert friction_lookup.identify(x, T, 0.01, **X, **known) == known
    x[1:] = -20e-3
    found = friction_lookup.identify(x, T, 0.01, **X, **known)
    assert found == friction_lookup.at_displacement(20.0, **X)
