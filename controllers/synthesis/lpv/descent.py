"""The source's descent to smoothly switching controllers, and its options.

    0  local controllers = an LPV design, fitted to the basis (``smooth.begin``)
    1  K, α fixed: the least γ and P       2  P, α fixed: the least γ and K
    3  P, K, γ fixed: the least η and α, of two parameters one after the other

Each least γ is backed off a little and a margin maximised, or the next step has
nowhere to go.  What holds at the points may fail between: ``smooth.certified`` tells.

Source: Hanifzadegan 2014, sec. 6.3, 6.4, eq. 6.35, 6.41 to 6.46, 6.57 to 6.59.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import minimize_scalar

from controllers.synthesis.lpv.elimination import (
    NoSolution,
    minimise,
    solver_package,
    weighted,
)
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.smooth import (
    Smooth,
    Weighted,
    certified,
    changes,
    rate_bound,
)
from controllers.synthesis.lpv.switching import Sided
from controllers.synthesis.lpv.systems import System

FREE = 20.0  # largest size of α's free number
LEAST_GAIN = 1e-3  # relative: γ that falls by less has not fallen


class Bound(NamedTuple):
    """F3: η, and (6.13)'s weights of the closed loop; None bounds K's own rate."""

    eta: Any
    weights: Weighted | None = None


class Bisected(NamedTuple):
    """A design, and per γ_d that was tried the γ that the descent came to."""

    design: Smooth
    tried: tuple[tuple[float, float], ...]


def descend(begun: Smooth, steps: int = 3) -> Smooth:
    """Return the design after step 1, and ``steps`` - 1 times steps 2 and 1.

    Raises:
        NoSolution: the solver says so.
        ImportError: the extra ``synthesis`` is not installed.
    """
    found = find_P(begun)
    for _ in range(steps - 1):
        found = find_P(find_K(found))
    return found


def bisect(begun: Smooth, eta_d: float, low: float, width: float) -> Bisected:
    """Return the design of least γ_d for which (6.35) is solved, by bisection.

    Args:
        begun: a design after step 1.
        eta_d: wanted η; as long as the design turns faster, its own counts (6.41).
        low: γ that no design has.
        width: of the bracket of γ_d at the end, relative.
    """
    best, high, tried = begun, begun.history[-1], []
    while high - low > width * high:
        gamma_d = (low + high) / 2
        best = reach(best, gamma_d, eta_d)
        tried.append((gamma_d, best.history[-1]))
        high = min(high, best.history[-1])
        low = low if high <= gamma_d else gamma_d
    return Bisected(best, tuple(tried))


def reach(design: Smooth, gamma_d: float, eta_d: float) -> Smooth:
    """Return the design after steps 2, 3 and 1, until γ <= γ_d or falls no more."""
    points = design.problem.bounded(design.problem.points)
    while design.history[-1] > gamma_d:
        eta = max(eta_d, rate_bound(design, points))
        try:
            found = find_P(find_shares(find_K(design, Bound(eta))))
        except NoSolution:
            break
        if found.history[-1] > (1 - LEAST_GAIN) * design.history[-1]:
            break
        design = found
    return design


def find_P(design: Smooth) -> Smooth:
    """Return the design with the P of least γ, K as it is (step 1)."""
    cp = solver_package()
    time, N = design.start.units.time, len(design.T)
    functions = len(design.problem.P_basis.values(design.problem.points[0].rho))
    shape = (len(design.K), functions, N, N)
    P = [cp.Variable(shape[2:], symmetric=True) for _ in range(shape[0] * shape[1])]

    def terms(point: Sided) -> tuple[Any, Any, System]:
        values, rates = design.problem.factors(point, time)
        return weighted(P, values), weighted(P, rates), design.loop(point.rho)

    positive = [
        T.T @ terms(point)[0] @ T >> design.problem.least * np.eye(N)
        for point in {point.rho: point for point in design.problem.points}.values()
        for T in [design.congruence(point.rho)]
    ]
    gamma = _least(cp, design, terms, positive)
    found = np.array([M.value for M in P]).reshape(shape)
    return replace(design, P=found, history=(*design.history, gamma))


def find_K(design: Smooth, bound: Bound | None = None) -> Smooth:
    """Return the design with the K of least γ, P as it is (step 2)."""
    cp = solver_package()
    K, terms = _unknown_K(cp, design)
    gamma = _least(cp, design, terms, _slower(cp, design, K, bound) if bound else [])
    return _with_K(design, K, gamma)


def find_slow_K(
    design: Smooth, relaxed: float = 1.02, weights: Weighted | None = None
) -> Smooth:
    """Return the design with the K of least η at ``relaxed`` times γ (6.46)."""
    cp = solver_package()
    K, terms = _unknown_K(cp, design)
    eta, gamma = cp.Variable(), relaxed * design.history[-1]
    bounded = _demanded(cp, design, terms, gamma / design.start.units.gain, 0.0)
    bounded += _slower(cp, design, K, Bound(eta, weights))
    minimise(cp, cp.Minimize(eta), bounded)
    return _with_K(design, K, gamma)


def find_shares(design: Smooth) -> Smooth:
    """Return the design with the α of least η that keep γ (step 3).

    Of two parameters one α after the other, until η falls no more (3-a, 3-b).
    Degree 6 leaves each α one number.
    """
    points = design.problem.bounded(design.problem.points)
    eta, before = rate_bound(design, points), np.inf
    while eta < (1 - LEAST_GAIN) * before:
        for i in range(len(design.free)):
            design = _with_share(design, i, points)
        eta, before = rate_bound(design, points), eta
    return design


def _with_share(design: Smooth, i: int, points: tuple[Sided, ...]) -> Smooth:
    """Return the design with the free number of one α that makes η least.

    F1 is convex in it: where the least η would lose γ, the last number found on the
    way there that does not is taken.
    """
    gamma = design.problem.back_off * design.history[-1]
    now = design.free[i]

    def with_free(c: float) -> Smooth:
        return replace(design, free=(*design.free[:i], c, *design.free[i + 1 :]))

    best = minimize_scalar(
        lambda c: rate_bound(with_free(c), points),
        bounds=(-FREE, FREE),
        method="bounded",
        options={"xatol": 1e-2, "maxiter": 25},
    )
    for reach in 0.5 ** np.arange(7):
        found = with_free(now + float(reach * (best.x - now)))
        if certified(found, design.problem.points) <= gamma:
            return found if best.fun < rate_bound(design, points) else design
    return design


def _unknown_K(cp: Any, design: Smooth) -> tuple[list[Any], Any]:
    """Return unknown matrices K_ik and the terms of F1 in them."""
    shape = design.K.shape
    K = [cp.Variable(shape[2:]) for _ in range(shape[0] * shape[1])]

    def terms(point: Sided) -> tuple[Any, Any, Any]:
        here = weighted(K, design.factors(point.rho))
        return *design.storage(point), _open_loop(design, point.rho, here)

    return K, terms


def _slower(cp: Any, design: Smooth, K: list[Any], bound: Bound) -> list[Any]:
    """Return F3 at all points: no rate exceeds η, of two parameters their sum."""
    time, found = design.start.units.time, []

    def rates(point: Sided) -> list[Any]:
        if bound.weights is None:
            moved = changes(design.factors, point)
            return [weighted(K, time * factors) for factors in moved]
        left, right = bound.weights

        def loop(rho: Values) -> Any:
            found = _open_loop(design, rho, weighted(K, design.factors(rho)))
            rows = [[found.A, found.B], [found.C, found.D]]
            return time * (left @ cp.bmat(rows) @ right)

        return changes(loop, point)

    for point in design.problem.bounded(design.problem.points):
        moving = rates(point)
        parts = cp.Variable(len(moving)) if len(moving) > 1 else [bound.eta]
        for M, eta in zip(moving, parts, strict=True):
            m, n = M.shape
            found.append(cp.bmat([[eta * np.eye(m), M], [M.T, eta * np.eye(n)]]) >> 0)
        if len(moving) > 1:
            found.append(cp.sum(parts) <= bound.eta)
    return found


def _with_K(design: Smooth, K: list[Any], gamma: float) -> Smooth:
    found = np.array([M.value for M in K]).reshape(design.K.shape)
    return replace(design, K=found, history=(*design.history, gamma))


def _least(
    cp: Any, design: Smooth, terms: Callable[[Sided], Any], others: list[Any]
) -> float:
    """Minimise γ, back off, and leave the unknowns where the margin is largest."""

    def inequalities(gamma: Any, margin: Any) -> list[Any]:
        return others + _demanded(cp, design, terms, gamma, margin)

    gamma, margin = cp.Variable(), cp.Variable()
    minimise(cp, cp.Minimize(gamma), inequalities(gamma, 0.0))
    least = float(gamma.value)
    bounded = [*inequalities(design.problem.back_off * least, margin), margin <= 1e-2]
    minimise(cp, cp.Maximize(margin), bounded)
    return least * design.start.units.gain


def _demanded(
    cp: Any, design: Smooth, terms: Callable[[Sided], Any], gamma: Any, margin: Any
) -> list[Any]:
    """Return F1 at all points of the design, decay included."""
    decay, found = design.problem.decay * design.start.units.time, []
    for point in design.problem.points:
        P, rate, loop = terms(point)
        T = design.congruence(point.rho)
        Q = P @ loop.A + (P @ loop.A).T + 2 * decay * P + rate
        V, W = T.T @ P @ loop.B, T.T @ loop.C.T
        m, p = V.shape[1], W.shape[1]
        M = cp.bmat(
            [
                [T.T @ Q @ T, V, W],
                [V.T, -gamma * np.eye(m), loop.D.T],
                [W.T, loop.D, -gamma * np.eye(p)],
            ]
        )
        found.append((M + M.T) / 2 << -margin * np.eye(M.shape[0]))
    return found


def _open_loop(design: Smooth, rho: Values, K: Any) -> Any:
    """Return the closed loop as an expression in [A_K B_K; C_K D_K]."""
    plant = design.start.units.plant(design.problem.plant(rho))
    n, k = plant.order, len(design.T_K)
    (p, m), (q, u) = plant.D_11.shape, (len(plant.C_2), plant.B_2.shape[1])
    zero, inverse = np.zeros, np.linalg.inv(design.T)
    into = inverse @ np.block([[zero((n, k)), plant.B_2], [np.eye(k), zero((k, u))]])
    out = np.block([[zero((k, n)), np.eye(k)], [plant.C_2, zero((q, k))]]) @ design.T
    effort = np.hstack([zero((p, k)), plant.D_12])
    noise = np.vstack([zero((k, m)), plant.D_21])
    A = inverse @ block_diag(plant.A, zero((k, k))) @ design.T
    B = inverse @ np.vstack([plant.B_1, zero((k, m))])
    C = np.hstack([plant.C_1, zero((p, k))]) @ design.T
    return System(
        A + into @ K @ out,
        B + into @ K @ noise,
        C + effort @ K @ out,
        plant.D_11 + effort @ K @ noise,
    )
