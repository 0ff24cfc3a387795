"""Seeded noise: exact integers, white, normal, the same bits in every form."""

from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from fmus.build import build
from orchestrator.master.simulate import simulate
from orchestrator.system import Component, System
from plants._noise import CONSTANTS, P, logarithm, normals, turn
from plants.disturbances import noise as amplifier
from plants.sensors import noise as sensor

N = 1_000_000
PRIME = int(P)


def independent(k: int, seed: int) -> tuple[float, float]:
    """The generator in Python's integers and its functions."""
    left, right = divmod(k, PRIME)
    for constant in CONSTANTS:
        cubed = pow(right + seed + int(constant), 3, PRIME)
        left, right = right, (left + cubed) % PRIME
    radius = np.sqrt(-2 * np.log((left + 0.5) / PRIME))
    angle = 2 * np.pi * (right + 0.5) / PRIME
    return radius * np.cos(angle), radius * np.sin(angle)


@given(st.integers(0, 2**51), st.integers(0, PRIME - 1))
def test_the_field_is_computed_without_rounding(k: int, seed: int) -> None:
    assert normals(float(k), float(seed)) == pytest.approx(
        independent(k, seed), rel=1e-12, abs=1e-12
    )


def test_logarithm_and_turn_are_exact_to_a_rounding() -> None:
    u = np.concatenate([[0.5 / P, 1 - 0.5 / P], np.random.default_rng(3).random(1000)])
    with mpmath.workdps(40):
        angles = [2 * mpmath.pi * mpmath.mpf(one) for one in u.tolist()]
        ln = [float(mpmath.log(mpmath.mpf(one))) for one in u.tolist()]
        exact = [[float(f(a)) for a in angles] for f in (mpmath.cos, mpmath.sin)]
    np.testing.assert_allclose(logarithm(u), ln, rtol=4e-16, atol=0)
    np.testing.assert_allclose(turn(u), exact, rtol=0, atol=3e-16)


@pytest.mark.parametrize("seed", [1.0, 2.0])
def test_a_million_samples_are_white_and_normal(seed: float) -> None:
    n, _ = normals(np.arange(float(N)), seed)
    assert np.var(n) == pytest.approx(1, rel=0.01)
    assert abs(np.mean(n)) < 4 / np.sqrt(N)
    assert stats.kstest(n, "norm").pvalue > 0.01
    lines = 2 * np.abs(np.fft.rfft(n)[1:-1]) ** 2 / N  # each chi-square with 2
    bands = lines[: lines.size // 100 * 100].reshape(100, -1).sum(axis=1)
    degrees = 2 * (lines.size // 100)
    deviation = (bands - degrees) / np.sqrt(2 * degrees)
    assert 0.005 < stats.chi2.cdf(np.sum(deviation**2), 100) < 0.995


def test_other_seeds_other_ticks_and_both_outputs_are_independent() -> None:
    k = np.arange(N / 10)
    n, other = normals(k, 1.0)
    for second in (other, normals(k, 2.0)[0], normals(k + 1, 1.0)[0]):
        assert abs(np.mean(n * second)) < 4 / np.sqrt(k.size)


def test_sensor_and_amplifier_scale_it_and_nothing_is_added_without_sigma() -> None:
    n, _ = normals(7.0, 3.0)
    state = sensor.State(k=7.0)
    parameters = sensor.Parameters(sigma=2e-9, seed=3.0)
    x, y = sensor.step(state, sensor.Input(1e-3), parameters, 1e-3)
    assert (x.k, y.y) == (8.0, 1e-3 + 2e-9 * n)
    _, d = amplifier.step(
        amplifier.State(k=7.0), amplifier.Input(), amplifier.Parameters(0.5, 3.0), 1e-3
    )
    assert d.d == 0.5 * n
    _, quiet = sensor.step(state, sensor.Input(1e-3), sensor.Parameters(0.0), 1e-3)
    assert quiet.y == 1e-3


def test_the_same_seed_gives_the_same_bits_in_every_form(tmp_path: Path) -> None:
    T_s = Fraction(1, 20_000)
    runs = []
    for fmi, kind, executor in (
        (2, "native", "kernel"),
        (3, "native", "fused"),
        (3, "native", "kernel"),
        (2, "native", "python"),
        (3, "native", "python"),
        (2, "python", None),
    ):
        file = build("plants.disturbances.noise", fmi=fmi, kind=kind)
        parts = {"noise": Component("noise", file, T_s, parameters={"seed": 5.0})}
        system = System("noise", Fraction(1, 10), parts, {}, {"noise.d": (T_s,)})
        folder = tmp_path / f"{fmi} {kind} {executor}"
        runs.append(simulate(system, folder, executor=executor)["noise.d"].values)
    first = runs[0]
    for other in runs[1:]:
        np.testing.assert_array_equal(first.view(np.int64), other.view(np.int64))
    assert len(set(first)) == first.size
