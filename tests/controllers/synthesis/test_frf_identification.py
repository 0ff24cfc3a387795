"""Identification gives back the gantry it was shown and shows the source's misprint."""

import numpy as np
import pytest

from controllers.synthesis import frf_identification as fi
from controllers.synthesis.gantry.identification import mass_distribution
from plants.gantry import frame as gantry

p = gantry.Parameters()
g = gantry.geometry(0.0, p)
ALPHA_1 = g.a_2 / p.L
F_HZ = np.arange(60.0, 151.0)
TRUE = np.array([g.J, p.c, p.k])


def responses():
    s = 2j * np.pi * F_HZ[:, None, None]
    b = np.array([-g.a_1, g.a_2])
    return 1 / (p.m * s**2) + np.outer(b, b) / (g.J * s**2 + p.c * s + p.k)


def errors(G):
    """Errors of J, c, k in percent."""
    found = fi.identify(F_HZ, G, p.m, ALPHA_1, p.L)
    return 100 * (np.array(found[:3]) / TRUE - 1)


def noisy(level, seed):
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((2, *responses().shape)) * level / np.sqrt(2)
    return responses() * (1 + noise[0] + 1j * noise[1])


def test_clean_responses_give_the_gantry_exactly():
    assert np.abs(errors(responses())) == pytest.approx(0, abs=1e-9)
    found = fi.identify(F_HZ, responses(), p.m, ALPHA_1, p.L)
    assert found.frequency == pytest.approx(94.318, abs=1e-3)
    assert found.damping == pytest.approx(0.033819, abs=1e-6)


def test_the_misprinted_regressor_ruins_the_damping_and_hides_in_the_frequency(
    monkeypatch,
):
    right = fi.equations

    def misprinted(f_hz, G):
        A, b = right(f_hz, G)
        first = np.arange(0, len(A) // 2, 4)  # real part, first row and column
        A[first, 3:5] *= 2 * np.pi * f_hz[:, None]
        return A, b

    monkeypatch.setattr(fi, "equations", misprinted)
    J, c, k = errors(responses())
    assert (J, c, k) == pytest.approx((-1.00, -99.83, -0.98), abs=0.01)
    found = fi.identify(F_HZ, responses(), p.m, ALPHA_1, p.L)
    assert found.frequency - 94.3179 == pytest.approx(0.009, abs=5e-4)


def test_the_printed_constraint_matrix_has_a_redundant_row():
    B, _ = fi.constraints(p.m, ALPHA_1)
    no_external_friction = np.array([0, 0, 0, 1, 2, 1, 0, 0, 0])
    assert np.linalg.matrix_rank(B) == 6
    assert np.linalg.matrix_rank(np.vstack([B, no_external_friction])) == 6


@pytest.mark.parametrize(("level", "bound"), [(0.01, 1.0), (0.05, 5.0)])
def test_noise_leaves_the_identified_gantry_within_its_level(level, bound):
    found = np.array([errors(noisy(level, seed)) for seed in range(20)])
    # damping is what little the imaginary part near the mode tells
    assert np.all(np.std(found, axis=0) < bound)
    assert np.all(np.abs(np.mean(found, axis=0)) < bound * np.array([0.15, 0.45, 0.15]))


def test_a_constrained_solution_is_the_best_of_all_that_fit():
    G = noisy(0.05, 1)
    A, b = fi.equations(F_HZ, G)
    found = fi.identify(F_HZ, G, p.m, ALPHA_1, p.L)

    def residual(J, c, k):
        M = np.array([g.a_2**2 * p.m + J, g.a_1 * g.a_2 * p.m - J, g.a_1**2 * p.m + J])
        twist = np.array([1.0, -1.0, 1.0])
        theta = np.concatenate([M, c * twist, k * twist]) / p.L**2
        return np.sum((A @ theta - b) ** 2)

    best = residual(*found[:3])
    for i in range(3):
        for step in (-1e-3, 1e-3):
            other = list(found[:3])
            other[i] *= 1 + step
            assert residual(*other) > best


def test_held_inputs_are_divided_out_of_measured_responses():
    # a double integrator under a held sine, in closed form
    T_s, f_hz, n = 1e-3, np.array([10.0, 25.0]), 1000
    lines = (np.rint(f_hz * n * T_s)).astype(int)
    rng = np.random.default_rng(0)
    z = np.exp(2j * np.pi * np.fft.rfftfreq(n))
    u = np.zeros((2, n, 2))
    for experiment in range(2):
        for k in lines:
            amplitude, phase = 1 + rng.random(2), 2 * np.pi * rng.random(2)
            t = np.arange(n)[:, None]
            u[experiment] += amplitude * np.cos(2 * np.pi * k * t / n + phase)
    U = np.fft.rfft(u, axis=1)
    Y = np.zeros_like(U)
    for k in lines:
        Y[:, k] = U[:, k] * (T_s**2 / 2 * (z[k] + 1) / (z[k] - 1) ** 2)
    G = fi.responses(f_hz, T_s, u, np.fft.irfft(Y, n, axis=1))
    expected = -np.eye(2) / (2 * np.pi * f_hz[:, None, None]) ** 2
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    # what is left are the aliases of the hold, (f T_s)³
    assert np.abs(G - expected) / size == pytest.approx(0, abs=2 * 0.025**3)
    with pytest.raises(ValueError, match="whole periods"):
        fi.responses(np.array([10.5]), T_s, u, u)


def test_the_mass_distribution_is_that_of_the_forces():
    a = np.sin(np.linspace(0, 6, 100))
    noise = 1e-3 * np.cos(np.linspace(0, 60, 100))
    found = mass_distribution(1e-3, a, 1.5 * a + noise, 0.5 * a)
    assert found == pytest.approx(
        {"m": 2.0, "alpha_1": 0.75, "alpha_2": 0.25}, rel=1e-3
    )
    with pytest.raises(ValueError, match="does not accelerate"):
        mass_distribution(1e-3, 0 * a, a, a)
