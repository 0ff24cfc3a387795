"""LPV synthesis by elimination: the smallest γ for which X and Y exist.

First γ is minimised under the inequalities of ``inequalities`` at every point of
every region; then, γ backed off, t is maximised under [X tI; tI Y] ≥ 0, less a
little of the traces: without it I - XY is nearly singular and the controller
useless.  A decay margin in both makes what holds on a grid hold between as well.

Needs the extra ``synthesis`` (cvxpy, Clarabel).
"""

import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates
from controllers.synthesis.lpv.inequalities import null_x, null_y
from controllers.synthesis.lpv.kept import kept_gain
from controllers.synthesis.lpv.problem import Found, Problem
from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix

# of γ: at the optimum itself a solver's rounding may leave what keeps nothing
SLACKS = (1e-5, 1e-4, 1e-3)


class NoSolution(ValueError):
    """The solver found no X and Y."""


def eliminate(
    problem: Problem, units: Coordinates, solver: str = "CLARABEL", **options: Any
) -> tuple[tuple[Found, ...], tuple[Found, ...]]:
    """Return, per region, what belongs to the smallest γ and what to build from.

    X is common to all regions, Y each region's own; γ, X and Y are in ``units``.
    ``options`` are the solver's own.

    Raises:
        NoSolution: the solver says so.
        ImportError: the extra ``synthesis`` is not installed.
    """
    cp = solver_package()
    gamma = cp.Variable()
    unknowns = _Unknowns(cp, problem, units)
    minimise(
        cp, cp.Minimize(gamma), unknowns.inequalities(gamma, 1.0), solver, **options
    )
    smallest = float(gamma.value)
    found = best = unknowns.found(smallest)
    for slack in SLACKS:
        if _kept(problem, units, best):
            break
        best = tuple(scaled(1 + slack, one) for one in found)

    t, used = cp.Variable(), problem.back_off * smallest
    constraints = [*unknowns.inequalities(used, t), t >= 1]
    goal = cp.Maximize(t - problem.price * unknowns.traces())
    minimise(cp, goal, constraints, solver, **options)
    return best, unknowns.found(used)


def _kept(problem: Problem, units: Coordinates, found: tuple[Found, ...]) -> bool:
    return all(
        kept_gain(problem, units, region, one, region.points, problem.decay) < np.inf
        for region, one in zip(problem.regions, found, strict=True)
    )


def scaled(s: float, found: Found) -> Found:
    """Return sX and sY, which keep sγ where X and Y keep γ, for s > 1.

    s (XA + A'X) + s²/(sγ) XBB'X + C'C/(sγ) ≤ s (XA + A'X + XBB'X/γ + C'C/γ) < 0,
    of Y alike; [sX I; I sY] lies farther inside.
    """
    return Found(s * found.gamma, s * found.X, s * found.Y)


def solver_package() -> Any:
    """Return cvxpy.

    Raises:
        ImportError: it is not installed; the message says how.
    """
    try:
        import cvxpy
    except ImportError:
        raise ImportError(
            'designing anew needs cvxpy: pip install "feeddrive-cosim[synthesis]"'
        ) from None
    return cvxpy


class _Unknowns:
    """X and all Y, and the inequalities they are subject to."""

    def __init__(self, cp: Any, problem: Problem, units: Coordinates) -> None:
        first = problem.regions[0].points[0]
        n = problem.plant(first.rho).order
        self.cp, self.problem, self.units = cp, problem, units
        self.X = cp.Variable((n, n), symmetric=True)
        self.Y = [
            [
                cp.Variable((n, n), symmetric=True)
                for _ in region.basis.values(region.points[0].rho)
            ]
            for region in problem.regions
        ]

    def inequalities(self, gamma: Any, t: Any) -> list[Any]:
        """Return all constraints, with [X tI; tI Y] ≥ 0."""
        negative = [*self._of_points(gamma), *self._of_links()]
        eye = np.eye(self.X.shape[0])
        coupled = [
            self.cp.bmat([[self.X, t * eye], [t * eye, Y]]) >> 0
            for region, Y_k in zip(self.problem.regions, self.Y, strict=True)
            for Y in (weighted(Y_k, region.basis.values(p.rho)) for p in region.points)
        ]
        return [(M + M.T) / 2 << 0 for M in negative] + coupled

    def traces(self) -> Any:
        """Return the traces of X and of each Y in the middle of its region."""
        whole = self.cp.trace(self.X)
        for region, Y_k in zip(self.problem.regions, self.Y, strict=True):
            middle = region.points[len(region.points) // 2].rho
            whole += self.cp.trace(weighted(Y_k, region.basis.values(middle)))
        return whole

    def found(self, gamma: float) -> tuple[Found, ...]:
        X = np.array(self.X.value)
        return tuple(
            Found(gamma, X, np.array([Y.value for Y in Y_k])) for Y_k in self.Y
        )

    def _of_points(self, gamma: Any) -> Iterator[Any]:
        X, decay, time = self.X, self.problem.decay * self.units.time, self.units.time
        known: list[Matrix] = []
        for region, Y_k in zip(self.problem.regions, self.Y, strict=True):
            for point in region.points:
                p = self.units.plant(self.problem.plant(point.rho))
                seen = seen_by_x(p)
                if not any(np.allclose(seen, M, 1e-9, 1e-12) for M in known):
                    known.append(seen)
                    Q, V = X @ p.A + p.A.T @ X + 2 * decay * X, X @ p.B_1
                    yield self._whole(gamma, null_x(p), Q, V, p.C_1.T, p.D_11.T)
                Y = weighted(Y_k, region.basis.values(point.rho))
                Q = p.A @ Y + Y @ p.A.T + 2 * decay * Y
                for rate in point.rates:
                    slope = time * region.basis.slopes(point.rho, rate)
                    moving = weighted(Y_k, slope)
                    yield self._whole(
                        gamma, null_y(p), Q - moving, Y @ p.C_1.T, p.B_1, p.D_11
                    )

    def _of_links(self) -> Iterator[Any]:
        for link in self.problem.links:
            of, to = (
                weighted(self.Y[r], self.problem.regions[r].basis.values(link.rho))
                for r in (link.of, link.to)
            )
            yield to - of

    def _whole(self, gamma: Any, N: Matrix, Q: Any, V: Any, W: Any, D: Matrix) -> Any:
        m, p = D.shape
        M = self.cp.bmat(
            [
                [Q, V, W],
                [V.T, -gamma * np.eye(m), D],
                [W.T, D.T, -gamma * np.eye(p)],
            ]
        )
        return N.T @ M @ N


def seen_by_x(plant: GeneralisedPlant) -> Matrix:
    """Return what the inequality of X depends on: ẋ and z where y = 0.

    Points that agree in it demand the same of X, and are asked once.
    """
    n, m = plant.B_1.shape
    N = null_x(plant)[: n + m, : -len(plant.C_1)]
    return np.block([[plant.A, plant.B_1], [plant.C_1, plant.D_11]]) @ N


def minimise(
    cp: Any, goal: Any, constraints: list[Any], solver: str = "CLARABEL", **options: Any
) -> None:
    """Solve a problem; its variables hold the result.

    Raises:
        NoSolution: the solver says so.
    """
    problem = cp.Problem(goal, constraints)
    with warnings.catch_warnings():
        # what counts is whether the dense check holds, not the solver's opinion
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver=solver, **options)
        except cp.SolverError as error:
            raise NoSolution(f"{solver} failed: {error}") from None
    if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise NoSolution(f"{solver} says {problem.status}")


def weighted(coefficients: Sequence[Any], factors: Matrix) -> Any:
    """Return Σ f_k Y_k of matrices that a solver still looks for."""
    terms = [f * Y for f, Y in zip(factors, coefficients, strict=True) if f != 0.0]
    return sum(terms) if terms else np.zeros(coefficients[0].shape)
