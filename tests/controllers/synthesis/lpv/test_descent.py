"""The descent to smooth switching, on a plant of one state in two parameters."""

from itertools import product

import numpy as np
import pytest

from controllers.synthesis.lpv.descent import (
    Bound,
    bisect,
    find_K,
    find_P,
    find_shares,
    find_slow_K,
)
from controllers.synthesis.lpv.design import design
from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.lpv.problem import Problem, Region, affine, grid
from controllers.synthesis.lpv.smooth import (
    Smooth,
    Weighted,
    begin,
    certified,
    rate_bound,
)
from controllers.synthesis.lpv.switching import (
    Sided,
    Switching,
    Transition,
    both_sides,
)
from controllers.synthesis.lpv.systems import GeneralisedPlant

RATES = (0.5, 0.2)
CUTS = (Transition(0, -0.2, 0.2), Transition(1, 0.1, 0.5))


def plant(rho: tuple[float, ...]) -> GeneralisedPlant:
    """ẋ = (1.5 ρ_1² + ρ_2) x + (2 + ρ_2) u + f; z = (x, u/2), y = x + n/5.

    ρ_2 is 0 if there is one parameter.
    """
    one, zero = np.ones((1, 1)), np.zeros((1, 1))
    second = rho[1] if len(rho) == 2 else 0.0
    return GeneralisedPlant(
        A=(1.5 * rho[0] ** 2 + second) * one,
        B_1=np.hstack([one, zero]),
        B_2=(2 + second) * one,
        C_1=np.vstack([one, zero]),
        C_2=one,
        D_11=np.zeros((2, 2)),
        D_12=np.vstack([zero, one / 2]),
        D_21=np.hstack([zero, one / 5]),
    )


def points(parameters: int, n: int = 0) -> tuple[Sided, ...]:
    """Both sides of every end, n values in each part of either parameter."""
    values = [
        both_sides(
            cut,
            np.array([-1.0, *np.linspace(-1, cut.low, n + 2)[1:-1]]),
            np.linspace(cut.low, cut.high, n + 2)[1:-1],
            np.array([1.0, *np.linspace(1, cut.high, n + 2)[1:-1]]),
        )
        for cut in CUTS[:parameters]
    ]
    rates = list(product(*((-r, r) for r in RATES[:parameters])))
    found = []
    for there, rate in product(product(*values), rates):
        rho, sides = zip(*there, strict=True)
        found.append(Sided(rho, rate, sides))
    return tuple(found)


def start(parameters: int) -> Smooth:
    """Step 0 from one LPV design."""
    three, cuts = (-1.0, 0.0, 1.0), CUTS[:parameters]
    basis = affine([0.0] * parameters, [1.0] * parameters)
    axes = (three,) * parameters
    problem = Problem(
        plant=plant,
        regions=(Region(grid(*axes, rates=RATES[:parameters]), basis),),
        frozen=((-1.0,) * parameters, (0.0,) * parameters, (1.0,) * parameters),
        axes=(axes,),
        T_s=1e-3,
        decay=0.01,
        time=1.0,
    )
    switched = Switching(
        plant, cuts, lambda rho: np.array([1.0, *rho]), basis, points(parameters), 0.01
    )
    ends = [((-1.0, cut.high), (cut.low, 1.0)) for cut in cuts]
    fits = [
        [tuple(map(float, rho)) for rho in product(*(np.linspace(*e, 5) for e in both))]
        for both in product(*ends)
    ]
    return begin(switched, design(problem), (0.0,) * parameters, fits)


@pytest.fixture(scope="module", params=[1, 2])
def stepped(request: pytest.FixtureRequest) -> Smooth:
    """A design after step 1, of one parameter or (--every-form) of two."""
    if request.param == 2 and not request.config.getoption("--every-form"):
        pytest.skip("a minute of inequalities; --every-form")
    return find_P(start(request.param))


def bound_of(design: Smooth) -> float:
    """The H-infinity optimum of a plant that stands at an end."""
    ends = ((1.0,) * len(design.free),)
    return float(frozen_optima(plant, ends, 1.0).max())


def test_four_controllers_are_one_where_they_meet() -> None:
    """α, β and products of both: no jump at an end, shares that sum to one."""
    basis = affine([0.0, 0.0], [1.0, 1.0])
    problem = Switching(plant, CUTS, lambda rho: np.ones(1), basis, (), 0.0)
    for rho in ((-0.2, 0.3), (0.2, 0.5), (0.05, 0.1), (1.0, 1.0)):
        shares = problem.shares(rho, (3.0, -2.0))
        assert sum(shares) == pytest.approx(1, abs=1e-14)
    corner = problem.shares((-0.2, 0.5), (3.0, -2.0))
    assert corner == pytest.approx([0, 1, 0, 0], abs=1e-12)


def test_storage_moves_as_it_is_told_on_either_side_of_an_end() -> None:
    """P is made of shares that have a kink at an end; any P_ik will do."""
    basis = affine([0.0, 0.0], [1.0, 1.0])
    problem = Switching(plant, CUTS, lambda rho: np.ones(1), basis, (), 0.0)
    step = 1e-6
    for point in points(2, 1):
        for axis, side in enumerate(point.sides):
            rate = tuple(r * (i == axis) for i, r in enumerate(point.rate))
            sign = float(np.sign(side * rate[axis])) or 1.0
            there = zip(point.rho, rate, strict=True)
            rho = tuple(x + sign * step * v for x, v in there)
            here, moving = problem.factors(point._replace(rate=rate), 1.0)
            near, _ = problem.factors(point._replace(rho=rho), 1.0)
            assert (near - here) / (sign * step) == pytest.approx(moving, abs=1e-5)


def test_each_step_of_the_descent_does_what_it_is_for(stepped: Smooth) -> None:
    """γ falls and stays above the frozen optimum, η keeps to its bound, F1 holds."""
    demanded, dense = stepped.problem.points, points(len(stepped.free), 3)
    before = rate_bound(stepped, demanded)
    slow = find_K(stepped, Bound(before / 2))
    assert rate_bound(slow, demanded) <= before / 2 * (1 + 1e-4)
    done = find_P(find_shares(slow))
    assert rate_bound(done, demanded) <= rate_bound(slow, demanded) * (1 + 1e-9)
    assert done.history[-1] <= 1.011 * stepped.history[-1]
    assert certified(done, dense) <= 1.03 * done.history[-1]
    assert done.history[-1] > bound_of(stepped)


def test_the_least_rate_at_a_relaxed_gain_is_below_the_first(stepped: Smooth) -> None:
    """Option (6.46), of K and, weighted, of the closed loop (6.13)."""
    demanded = stepped.problem.points
    slow = find_slow_K(stepped, 1.05)
    assert rate_bound(slow, demanded) < rate_bound(stepped, demanded)
    assert certified(slow, demanded) <= 1.0501 * stepped.history[-1]
    eye = np.eye(len(stepped.T) + 2)
    weights = Weighted(eye, eye)
    loop = find_slow_K(stepped, 1.05, weights)
    at_first, then = (rate_bound(d, demanded, weights) for d in (stepped, loop))
    assert then < at_first
    assert then <= rate_bound(slow, demanded, weights) * (1 + 1e-3)


def test_bisection_ends_between_what_is_reached_and_what_is_not(
    stepped: Smooth,
) -> None:
    low = bound_of(stepped)
    found = bisect(stepped, 1.0, low, 0.03)
    assert found.design.history[-1] <= stepped.history[-1]
    missed = [wanted for wanted, reached in found.tried if reached > wanted]
    assert max([low, *missed]) >= 0.97 * found.design.history[-1]
    # of two parameters the ends alone are demanded: too few for what lies between
    judged = stepped.problem.points if len(stepped.free) == 2 else points(1, 2)
    assert certified(found.design, judged) <= 1.03 * found.design.history[-1]
