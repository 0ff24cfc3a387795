"""H-infinity by Riccati equations, and the systems it works on."""

import control as ct
import numpy as np
import pytest

from controllers.synthesis.lpv.coordinates import suitable
from controllers.synthesis.lpv.h_infinity import h_infinity
from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.systems import (
    GeneralisedPlant,
    System,
    abscissa,
    continuous,
    poles,
    residualised,
    response,
    transformed,
    tustin,
)
from controllers.synthesis.lpv.weights import corner, decibels, shelf

RANDOM = np.random.default_rng(3)


def stable(n: int, inputs: int, outputs: int) -> System:
    A = RANDOM.normal(size=(n, n))
    A = A - (np.max(np.linalg.eigvals(A).real) + 0.3) * np.eye(n)
    return System(
        A,
        RANDOM.normal(size=(n, inputs)),
        RANDOM.normal(size=(outputs, n)),
        RANDOM.normal(size=(outputs, inputs)),
    )


def test_the_norm_is_that_of_python_control() -> None:
    system = stable(5, 2, 3)
    frequencies = np.geomspace(1e-3, 1e3, 20_001)
    G = ct.ss(*system).frequency_response(frequencies, squeeze=False).frdata
    by_grid = np.max(np.linalg.svd(np.moveaxis(G, -1, 0), compute_uv=False))
    assert peak(system)[0] == pytest.approx(by_grid, rel=1e-5)


def test_a_norm_of_an_unstable_system_is_refused() -> None:
    system = stable(3, 1, 1)
    with pytest.raises(ValueError, match="unstable"):
        peak(system._replace(A=system.A + 2 * np.eye(3)))


def test_tustin_and_its_inverse_are_those_of_scipy() -> None:
    system, T_s = stable(4, 2, 1), 0.01
    sampled = tustin(system, T_s)
    known = ct.sample_system(ct.ss(*system), T_s, "bilinear")
    z = np.exp(1j * np.array([0.01, 0.3, 2.0]))
    assert response(sampled, z)[:, 0, 1] == pytest.approx(
        known(z, squeeze=False)[0, 1], rel=1e-10
    )
    for found, given in zip(continuous(sampled, T_s), system, strict=True):
        assert found == pytest.approx(given, rel=1e-9, abs=1e-9)


def test_residualising_keeps_slow_poles_and_the_static_gain() -> None:
    slow, fast = stable(2, 1, 1), stable(1, 1, 1)
    A = np.block([[slow.A, np.ones((2, 1))], [np.zeros((1, 2)), 1e6 * fast.A]])
    whole = System(A, np.vstack([slow.B, fast.B]), np.hstack([slow.C, fast.C]), slow.D)
    whole = transformed(whole, RANDOM.normal(size=(3, 3)))
    kept = residualised(whole, 1e4)
    assert np.sort(poles(kept).real) == pytest.approx(
        np.sort(poles(slow).real), rel=1e-6
    )
    zero = np.zeros(1, dtype=complex)
    assert response(kept, zero) == pytest.approx(response(whole, zero), rel=1e-8)


def test_weights_have_the_gains_they_are_named_by() -> None:
    W = shelf(decibels(-140), decibels(4), 750.0, 3)
    low, high = 1 / np.abs(response(W, np.array([1e-6j, 1e9j])))[:, 0, 0]
    assert low == pytest.approx(decibels(-140), rel=1e-6)
    assert high == pytest.approx(decibels(4), rel=1e-6)
    low, high = (
        1
        / np.abs(
            response(corner(decibels(-110), decibels(-175), 6.0), np.array([0, 1e9j]))
        )[:, 0, 0]
    )
    assert low == pytest.approx(decibels(-110), rel=1e-9)
    assert high == pytest.approx(decibels(-175), rel=1e-6)


def mixed_sensitivity(unstable: float) -> GeneralisedPlant:
    """1/(s - a) with weights on error and command, D_11 not zero."""
    return GeneralisedPlant(
        A=np.array([[unstable, 0.0], [-1.0, -0.1]]),
        B_1=np.array([[0.0, 0.3], [1.0, 0.0]]),
        B_2=np.array([[1.0], [0.0]]),
        C_1=np.array([[-0.5, 1.0], [0.0, 0.0]]),
        C_2=np.array([[-1.0, 0.0]]),
        D_11=np.array([[0.5, 0.0], [0.0, 0.0]]),
        D_12=np.array([[0.0], [0.2]]),
        D_21=np.array([[1.0, 0.0]]),
    )


@pytest.mark.parametrize("unstable", [-2.0, 0.0, 3.0])
def test_the_controller_keeps_what_gamma_says(unstable: float) -> None:
    plant = mixed_sensitivity(unstable)
    found = h_infinity(plant, time=1.0)
    loop = plant.close(found.K)
    assert abscissa(loop) < 0
    assert peak(loop)[0] == pytest.approx(found.norm, rel=1e-6)
    assert found.norm <= 1.001 * found.gamma


def test_no_other_controller_is_better() -> None:
    """A static gain, the best of many, stays above the optimum."""
    plant = mixed_sensitivity(3.0)
    best = np.inf
    for gain in np.geomspace(3.1, 100.0, 60):
        K = System(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[gain]])
        loop = plant.close(K._replace(D=np.array([[gain]])))
        if abscissa(loop) < 0:
            best = min(best, peak(loop)[0])
    assert h_infinity(plant, time=1.0).norm < best


def test_units_change_the_numbers_and_not_the_loop() -> None:
    plant = mixed_sensitivity(3.0)
    units = suitable([plant], time=1e-2, gain=7.0)
    K = System(
        np.array([[-3.0]]), np.array([[2.0]]), np.array([[5.0]]), np.zeros((1, 1))
    )
    loop = units.plant(plant).close(units.scaled(K))
    s = 1j * np.array([0.1, 2.0, 30.0])
    told = response(plant.close(K), s)
    assert response(loop, 1e-2 * s) * 7.0 == pytest.approx(told, rel=1e-9)
    for M, N in zip(units.controller(units.scaled(K)), K, strict=True):
        assert pytest.approx(N, rel=1e-12) == M
