"""Contouring in the plane (Hanifzadegan 2014, chapter 8)."""

import numpy as np
import pytest

from controllers.synthesis.contouring_lpv import designs, figures, planar
from controllers.synthesis.lpv.elimination import seen_by_x
from controllers.synthesis.lpv.fourier import fitted, harmonics
from controllers.synthesis.lpv.systems import System, response
from plants.three_axis._axes import Axis, X, Y, modes


@pytest.mark.parametrize(
    ("axis", "gains"),
    [
        (X, {1: 0.0598905, 50: 2.30689e-4, 340: 1.13405e-5}),
        (Y, {1: 0.262082, 50: 2.79697e-4, 340: 1.74438e-5}),
    ],
)
def test_modal_blocks_have_the_gains_of_the_polynomials(
    axis: Axis, gains: dict[float, float]
) -> None:
    found = modes(axis)
    blocks = planar.axis_model(axis, np.inf)
    for omega, gain in gains.items():
        s = 1j * omega
        flexible = np.polyval(axis.numerator, s) / np.polyval(axis.denominator, s)
        printed = axis.gain / (s * (s - axis.pole)) * flexible
        assert abs(printed) == pytest.approx(gain, rel=1e-5)
        assert np.sum(found.residues / (s - found.poles)) == pytest.approx(
            printed, rel=1e-12
        )
        assert response(blocks, np.array([s]))[0, 0, 0] == pytest.approx(
            printed, rel=1e-12
        )


def test_the_frame_is_a_rotation_without_a_wrap() -> None:
    for theta in np.linspace(-7, 7, 9):
        T = planar.rotation(theta)
        assert pytest.approx(np.eye(2), abs=1e-14) == T @ T.T
        assert np.linalg.det(T) == pytest.approx(1, abs=1e-14)
        assert planar.rotation(theta + 2 * np.pi) == pytest.approx(T, abs=1e-14)


@pytest.mark.parametrize(
    ("theta", "gamma"), [(0.0, 32818), (0.7, 27678), (np.pi / 2, 24596)]
)
def test_frozen_directions_bound_every_design(theta: float, gamma: float) -> None:
    assert figures.frozen(theta) == pytest.approx(gamma, rel=5e-3)


def test_the_shipped_series_certifies_all_around() -> None:
    """γ 37163 is where the solver stops; the bound is that of θ = 0."""
    found = figures.certified()
    assert figures.frozen(0.0) <= found["gamma"] <= 1.02 * 37261
    assert found["dense"] <= 41000
    assert found["table"] <= 43000


def test_all_directions_ask_the_same_of_x() -> None:
    """The frame is undone at the input: one inequality of X serves every θ."""
    plant = planar.plant()
    first, other = (seen_by_x(plant((theta,))) for theta in (0.0, 2.0))
    assert np.allclose(first, other, rtol=1e-9, atol=1e-12)
    assert not np.allclose(plant((0.0,)).A, plant((2.0,)).A)


def test_a_series_repeats_what_it_can_hold() -> None:
    def at(theta: float) -> System:
        wave = np.array([[1 + np.cos(theta) - 2 * np.sin(2 * theta)]])
        return System(wave, wave, wave, wave)

    series = fitted([at(2 * np.pi * k / 16) for k in range(16)], 2, 1e-3)
    assert pytest.approx(at(0.7).A, rel=1e-12) == series.at((0.7,)).A
    assert (
        pytest.approx(series.system.A, rel=1e-12, abs=1e-12)
        == series.remade([at(rho[0]) for rho in series.points]).A
    )
    assert harmonics(np.array([0.0]), 2) == pytest.approx(np.array([[1, 1, 0, 1, 0]]))


def test_the_shipped_series_is_what_the_formulas_give() -> None:
    assert designs.verdict(designs.read()).difference < 1e-3
