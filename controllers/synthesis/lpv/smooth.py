"""Smooth switching between two LPV controllers, by the source's descent.

    K(ρ) = (1 - α) K_1(ρ) + α K_2(ρ),   K_i = Σ_k f_k(ρ) K_ik,   α of ``transition``
    P(ρ) = (1 - s) P_1(ρ) + s P_2(ρ),   P_i = Σ_k p_k(ρ) P_ik,   s linear

    0  K_1 = K_2 = an LPV design, fitted to the basis
    1  K fixed: the least γ and P          2  P fixed: the least γ and K

P has a slope on either side of the transition's ends: the inequality is demanded for
both.  Each least γ is backed off a little and a margin maximised, or the next step
has nowhere to go.  What holds at the points may fail between: ``certified`` tells.

Source: Hanifzadegan 2014, sec. 6.2, 6.3, eq. 6.14, 6.19, 6.35 to 6.40.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from controllers.synthesis.lpv.design import Design
from controllers.synthesis.lpv.elimination import minimise, solver_package, weighted
from controllers.synthesis.lpv.inequalities import Storage, gain_of_loop, storage
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.reconstruction import controller
from controllers.synthesis.lpv.switching import Sided, Switching
from controllers.synthesis.lpv.systems import Matrix, System, transformed
from controllers.synthesis.lpv.transition import share


@dataclass(frozen=True)
class Smooth:
    """Two controllers and what certifies their blend, in the units of ``start``.

    ``K`` is (2, k, n + u, n + y), its states those of ``start`` over ``T_K``; ``P`` is
    (2, p, N, N) in states of which ``T`` is the inverse factor.  ``history`` holds γ
    after each step.
    """

    problem: Switching
    start: Design
    T_K: Matrix
    T: Matrix
    K: Matrix
    P: Matrix
    history: tuple[float, ...] = ()

    def shares(self, x: float) -> tuple[float, float]:
        """Return the shares of both controllers at x."""
        p = self.problem
        alpha = share((x - p.low) / (p.high - p.low))
        return 1 - alpha, alpha

    def controller(self, rho: Values) -> System:
        """Return K at ρ in scaled units."""
        f = self.problem.K_basis(rho)
        return _split(np.einsum("i,k,ikab->ab", self.shares(rho[0]), f, self.K), self)

    def loop(self, rho: Values, K: System | None = None) -> System:
        """Return the closed loop at ρ in scaled units and states of P."""
        plant = self.start.units.plant(self.problem.plant(rho))
        closed = plant.close(self.controller(rho) if K is None else K)
        return transformed(closed, self.T)


def begin(
    problem: Switching, start: Design, at: Values, fits: Sequence[Sequence[Values]]
) -> Smooth:
    """Return step 0: the start's controllers fitted over either region.

    Args:
        problem: what is switched.
        start: a single LPV design of one region.
        at: ρ whose storage function becomes the unit of the states.
        fits: per region the values of ρ that its controller is fitted at, those of
            the transition included.
    """
    n = start.problem.plant(at).order
    P, _ = _storage(start, at, (0.0,) * len(at))
    T_K = np.linalg.inv(np.linalg.cholesky(P[n:, n:])).T
    rest = block_diag(np.eye(n), T_K)
    T = np.linalg.inv(np.linalg.cholesky(rest.T @ P @ rest)).T
    fitted = []
    for near in fits:
        F = np.array([problem.K_basis(rho) for rho in near])
        wanted = [_joined(transformed(_rebuilt(start, rho), T_K)) for rho in near]
        rows = np.array([M.ravel() for M in wanted])
        found = np.linalg.lstsq(F, rows, rcond=None)[0]
        fitted.append(found.reshape(-1, *wanted[0].shape))
    p = len(problem.P_basis.values(at))
    return Smooth(
        problem, start, T_K, T, np.array(fitted), np.zeros((2, p, 2 * n, 2 * n))
    )


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


def find_P(design: Smooth) -> Smooth:
    """Return the design with the P of least γ, K as it is (step 1)."""
    cp = solver_package()
    shape = design.P.shape
    P = [cp.Variable(shape[2:], symmetric=True) for _ in range(shape[0] * shape[1])]

    def terms(point: Sided) -> tuple[Any, Any, System]:
        values, rates = _factors(design, point)
        return weighted(P, values), weighted(P, rates), design.loop(point.rho)

    positive = [
        T.T @ terms(point)[0] @ T >> design.problem.least * np.eye(shape[2])
        for point in design.problem.points
        for T in [_congruence(design, point.rho)]
    ]
    gamma = _least(cp, design, terms, positive)
    found = np.array([M.value for M in P]).reshape(shape)
    return replace(design, P=found, history=(*design.history, gamma))


def find_K(design: Smooth, eta: float | None = None) -> Smooth:
    """Return the design with the K of least γ, P as it is (step 2).

    ``eta`` bounds the rate of K as of ``rate_bound`` (6.30); None leaves it free.
    """
    cp = solver_package()
    K, terms, rates = _unknown_K(cp, design)
    bounds = [] if eta is None else _slower(cp, rates, eta)
    gamma = _least(cp, design, terms, bounds)
    return _with_K(design, K, gamma)


def find_slow_K(design: Smooth, relaxed: float = 1.02) -> Smooth:
    """Return the design with the K of least η at ``relaxed`` times γ (6.46)."""
    cp = solver_package()
    K, terms, rates = _unknown_K(cp, design)
    eta, gamma = cp.Variable(), relaxed * design.history[-1]
    bounded = _demanded(cp, design, terms, gamma / design.start.units.gain, 0.0)
    minimise(cp, cp.Minimize(eta), bounded + _slower(cp, rates, eta))
    return _with_K(design, K, gamma)


def _unknown_K(cp: Any, design: Smooth) -> tuple[list[Any], Any, list[Any]]:
    """Return unknown matrices K_ik, the terms of F1 in them, and K's rates."""
    shape = design.K.shape
    K = [cp.Variable(shape[2:]) for _ in range(shape[0] * shape[1])]
    P = design.P.reshape(-1, *design.P.shape[2:])

    def factors(rho: Values) -> Matrix:
        return np.outer(design.shares(rho[0]), design.problem.K_basis(rho)).ravel()

    def terms(point: Sided) -> tuple[Any, Any, Any]:
        values, rates = _factors(design, point)
        loop = _open_loop(design, point.rho, weighted(K, factors(point.rho)))
        return np.tensordot(values, P, 1), np.tensordot(rates, P, 1), loop

    time = design.start.units.time
    changes = [time * _change(factors, point) for point in design.problem.points]
    return K, terms, [weighted(K, change) for change in changes]


def _slower(cp: Any, rates: list[Any], eta: Any) -> list[Any]:
    """Return F3: no rate of K exceeds η."""
    found = []
    for M in rates:
        m, n = M.shape
        found.append(cp.bmat([[eta * np.eye(m), M], [M.T, eta * np.eye(n)]]) >> 0)
    return found


def _with_K(design: Smooth, K: list[Any], gamma: float) -> Smooth:
    found = np.array([M.value for M in K]).reshape(design.K.shape)
    return replace(design, K=found, history=(*design.history, gamma))


def certified(
    design: Smooth,
    points: Sequence[Sided],
    K: Callable[[Values], System] | None = None,
) -> float:
    """Return the γ that P proves at points; no solver is asked.

    ``K`` gives another controller in scaled units, a table's for example.
    """
    P, worst = design.P.reshape(-1, *design.P.shape[2:]), 0.0
    for point in points:
        values, rates = _factors(design, point)
        T = _congruence(design, point.rho)
        loop = transformed(design.loop(point.rho, K and K(point.rho)), T)
        P_here, moving = (np.tensordot(f, P, axes=1) for f in (values, rates))
        worst = max(worst, gain_of_loop(loop, T.T @ P_here @ T, T.T @ moving @ T))
    return worst * design.start.units.gain


def rate_bound(design: Smooth, points: Sequence[Sided], step: float = 1e-6) -> float:
    """Return η, the largest ‖dK/dt‖₂ at points, in scaled units and states of K.

    It depends on these units and states: compare it within one design only.
    """
    worst = 0.0
    for point in points:
        change = _change(lambda rho: _joined(design.controller(rho)), point, step)
        worst = max(worst, float(np.linalg.norm(change, 2)))
    return worst * design.start.units.time


def _change(of: Callable[[Values], Matrix], point: Sided, step: float = 1e-6) -> Matrix:
    """Return the rate (1/s) at which a matrix over ρ changes at a point."""
    ahead, behind = (
        tuple(r + sign * step * v for r, v in zip(point.rho, point.rate, strict=True))
        for sign in (1, -1)
    )
    return np.asarray((of(ahead) - of(behind)) / (2 * step))


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
        T = _congruence(design, point.rho)
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


def _factors(design: Smooth, point: Sided) -> tuple[Matrix, Matrix]:
    """Return the factors of all P_ik and their rates, per unit of time."""
    p, (rho, rate, side) = design.problem, point
    values = p.P_basis.values(rho)
    moving = design.start.units.time * p.P_basis.slopes(rho, rate)
    s, s_rate = (rho[0] - p.low) / (p.high - p.low), 0.0
    inside = 0 < s < 1 or (s == 0 and side > 0) or (s == 1 and side < 0)
    if inside:
        s_rate = design.start.units.time * rate[0] / (p.high - p.low)
    s = float(np.clip(s, 0.0, 1.0))
    return (
        np.concatenate([(1 - s) * values, s * values]),
        np.concatenate(
            [(1 - s) * moving - s_rate * values, s * moving + s_rate * values]
        ),
    )


def _congruence(design: Smooth, rho: Values) -> Matrix:
    """Return T with T'PT = I for the start's P: inequalities of one size."""
    P, _ = _storage(design.start, rho, (0.0,) * len(rho))
    n = len(design.T_K)
    whole = block_diag(np.eye(len(P) - n), design.T_K) @ design.T
    return np.asarray(np.linalg.inv(np.linalg.cholesky(whole.T @ P @ whole)).T)


def _storage(start: Design, rho: Values, rate: Values) -> tuple[Matrix, Matrix]:
    basis, used = start.problem.regions[0].basis, start.used[0]
    Y = used.at(basis.values(rho))
    moving = used.at(start.units.time * basis.slopes(rho, rate))
    return storage(Storage(used.X, Y, moving))


def _rebuilt(start: Design, rho: Values) -> System:
    used, basis = start.used[0], start.problem.regions[0].basis
    plant = start.units.plant(start.problem.plant(rho))
    return controller(plant, used.X, used.at(basis.values(rho)), used.gamma)


def _joined(K: System) -> Matrix:
    return np.block([[K.A, K.B], [K.C, K.D]])


def _split(M: Matrix, design: Smooth) -> System:
    n = len(design.T_K)
    return System(M[:n, :n], M[:n, n:], M[n:, :n], M[n:, n:])


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
