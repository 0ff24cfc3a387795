"""The inequalities and what follows from them, against plain linear algebra."""

import numpy as np
import pytest

from controllers.synthesis.lpv.design import design, lower_bound, verify
from controllers.synthesis.lpv.elimination import scaled
from controllers.synthesis.lpv.inequalities import (
    Storage,
    coupling,
    gain_of_loop,
    gain_of_x,
    gain_of_y,
    least_gain,
    storage,
)
from controllers.synthesis.lpv.kept import kept_gain
from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.problem import Problem, Region, affine, grid
from controllers.synthesis.lpv.systems import GeneralisedPlant, System

RANDOM = np.random.default_rng(5)


def test_the_least_gain_is_where_the_matrix_turns_definite() -> None:
    M = RANDOM.normal(size=(6, 6))
    M = M + M.T - 8 * np.diag([1.0, 1, 1, 0, 0, 0])
    E = np.diag([0.0, 0, 0, 1, 2, 3])
    gamma = least_gain(M, E)
    assert np.linalg.eigvalsh(M - 1.0001 * gamma * E)[-1] < 0
    assert np.linalg.eigvalsh(M - 0.9999 * gamma * E)[-1] > 0


def test_no_gain_helps_an_unstable_loop() -> None:
    loop = System(np.eye(1), np.eye(1), np.eye(1), np.zeros((1, 1)))
    assert gain_of_loop(loop, np.eye(1), np.zeros((1, 1))) == np.inf


def test_a_certificate_is_never_below_the_norm() -> None:
    A = RANDOM.normal(size=(4, 4))
    A -= (np.max(np.linalg.eigvals(A).real) + 1) * np.eye(4)
    B, C = RANDOM.normal(size=(4, 2)), RANDOM.normal(size=(3, 4))
    loop = System(A, B, C, RANDOM.normal(size=(3, 2)))
    norm = peak(loop)[0]
    for _ in range(20):
        P = RANDOM.normal(size=(4, 4))
        assert gain_of_loop(loop, P @ P.T, np.zeros((4, 4))) >= norm


def spring(rho: tuple[float, ...]) -> GeneralisedPlant:
    """An undamped mass on a spring that varies; force disturbs, speed is small."""
    return GeneralisedPlant(
        A=np.array([[0.0, 1.0], [-rho[0], 0.0]]),
        B_1=np.array([[0.0, 0.0], [1.0, 0.0]]),
        B_2=np.array([[0.0], [1.0]]),
        C_1=np.array([[0.0, 1.0], [0.0, 0.0]]),
        C_2=np.array([[1.0, 0.0]]),
        D_11=np.zeros((2, 2)),
        D_12=np.array([[0.0], [0.5]]),
        D_21=np.array([[0.0, 0.1]]),
    )


def problem(*, rate: float = 0.5, decay: float = 0.02) -> Problem:
    points = (1.0, 2.0, 3.0)
    return Problem(
        plant=spring,
        regions=(Region(grid(points, rates=[rate]), affine([2.0], [1.0])),),
        frozen=((1.0,), (3.0,)),
        axes=((points,),),
        T_s=0.02,
        decay=decay,
        time=1.0,
        price=1e-4,
    )


def test_a_design_certifies_between_its_points_and_stays_above_frozen_plants() -> None:
    found = design(problem())
    dense = grid(np.linspace(1.0, 3.0, 41), rates=[0.5])
    verdict = verify(found, (dense,))
    assert verdict.gamma == pytest.approx(found.gamma, rel=1e-4)
    assert lower_bound(problem()) <= found.gamma
    assert verdict.dense[0] <= 1.01 * found.used[0].gamma
    # the table adds interpolation and sampling, little of both
    assert verdict.table[0] <= 1.02 * found.used[0].gamma
    assert verdict.difference < 1e-8


def test_multiples_of_x_and_y_keep_as_many_times_the_gain_farther_inside() -> None:
    """What makes a certificate of an optimum that a solver rounded past its edge."""
    told = problem()
    found = design(told)
    best, units = found.best[0], found.units
    region = told.regions[0]
    for s in (1 + 1e-5, 1.1, 3.0):
        more = scaled(s, best)
        kept = kept_gain(told, units, region, more, region.points, told.decay)
        assert kept <= s * best.gamma * (1 + 1e-6)
        assert coupling(more.X, more.at(region.basis.values((1.0,)))) > coupling(
            best.X, best.at(region.basis.values((1.0,)))
        )


def test_faster_parameters_cost_gain() -> None:
    slow, fast = (design(problem(rate=rate)).gamma for rate in (0.1, 5.0))
    assert fast > 1.01 * slow


def test_the_storage_function_belongs_to_the_controller() -> None:
    """P of the closed loop certifies about the γ that X and Y were made for."""
    found = design(problem())
    used, units = found.used[0], found.units
    region = found.problem.regions[0]
    rho, rate = (2.4,), (0.5,)
    Y = used.at(region.basis.values(rho))
    moving = used.at(region.basis.slopes(rho, rate))
    P, P_rate = storage(Storage(used.X, Y, moving))
    assert np.linalg.eigvalsh(P)[0] > 0
    step = 1e-6
    later = storage(Storage(used.X, Y + step * moving, moving))[0]
    assert (later - P) / step == pytest.approx(P_rate, rel=1e-4, abs=1e-4)
    plant = units.plant(spring(rho))
    assert gain_of_x(plant, used.X) <= 1.01 * used.gamma
    assert gain_of_y(plant, Y, moving) <= 1.01 * used.gamma
