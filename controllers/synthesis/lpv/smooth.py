"""Smooth switching between LPV controllers: their blend, its γ and its rate.

    K(ρ) = Σ α_i(ρ) K_i(ρ),   K_i = Σ_k f_k(ρ) K_ik,   α_i products of ``transition``
    P(ρ) = Σ s_i(ρ) P_i(ρ),   P_i = Σ_k p_k(ρ) P_ik,   s_i products of linear shares

P has a slope on either side of a transition's ends: the inequality is demanded for
both.  ``descent`` looks for K and P with a solver; nothing here asks one.

Source: Hanifzadegan 2014, sec. 6.1, 6.2, 6.4, eq. 6.12 to 6.14, 6.19, 6.36 to 6.40,
6.50, 6.51, 6.55.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from controllers.synthesis.lpv.design import Design
from controllers.synthesis.lpv.inequalities import Storage, gain_of_loop, storage
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.reconstruction import controller
from controllers.synthesis.lpv.switching import Sided, Switching
from controllers.synthesis.lpv.systems import Matrix, System, transformed


@dataclass(frozen=True)
class Smooth:
    """Local controllers and what certifies their blend, in the units of ``start``.

    ``K`` is (r, k, n + u, n + y), its states those of ``start`` over ``T_K``; ``P`` is
    (r, p, N, N) in states of which ``T`` is the inverse factor; None is the start's
    own, P⁻¹ affine in Y.  ``free`` holds each transition's free number, ``history`` γ
    after each step.
    """

    problem: Switching
    start: Design
    T_K: Matrix
    T: Matrix
    K: Matrix
    P: Matrix | None
    free: tuple[float, ...]
    history: tuple[float, ...] = ()

    def factors(self, rho: Values) -> Matrix:
        """Return the factors of all K_ik at ρ."""
        shares = self.problem.shares(rho, self.free)
        return np.kron(shares, self.problem.K_basis(rho))

    def controller(self, rho: Values) -> System:
        """Return K at ρ in scaled units."""
        flat = self.K.reshape(-1, *self.K.shape[2:])
        return split(np.tensordot(self.factors(rho), flat, 1), len(self.T_K))

    def loop(self, rho: Values, K: System | None = None) -> System:
        """Return the closed loop at ρ in scaled units and states of P."""
        plant = self.start.units.plant(self.problem.plant(rho))
        closed = plant.close(self.controller(rho) if K is None else K)
        return transformed(closed, self.T)

    def storage(self, point: Sided) -> tuple[Matrix, Matrix]:
        """Return P and Ṗ at a point."""
        if self.P is None:
            P, moving = _storage(self.start, point.rho, point.rate)
            return self._in_states(P), self._in_states(moving)
        P = self.P.reshape(-1, *self.P.shape[2:])
        values, rates = self.problem.factors(point, self.start.units.time)
        return np.tensordot(values, P, 1), np.tensordot(rates, P, 1)

    def congruence(self, rho: Values) -> Matrix:
        """Return T with T'PT = I for the start's P: inequalities of one size."""
        P, _ = _storage(self.start, rho, (0.0,) * len(rho))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self._in_states(P))).T)

    def _in_states(self, P: Matrix) -> Matrix:
        n = len(self.T_K)
        T = block_diag(np.eye(len(P) - n), self.T_K) @ self.T
        return np.asarray(T.T @ P @ T)


class Weighted(NamedTuple):
    """W_L and W_R of (6.13), for [A B; C D] of the closed loop in states of P."""

    left: Matrix
    right: Matrix


def begin(
    problem: Switching, start: Design, at: Values, fits: Sequence[Sequence[Values]]
) -> Smooth:
    """Return step 0: the start's controllers fitted over each region.

    Args:
        problem: what is switched.
        start: a single LPV design of one region.
        at: ρ whose storage function becomes the unit of the states.
        fits: per region the values of ρ that its controller is fitted at, those of
            the transitions included.
    """
    n = start.problem.plant(at).order
    P, _ = _storage(start, at, (0.0,) * len(at))
    T_K = np.linalg.inv(np.linalg.cholesky(P[n:, n:])).T
    rest = block_diag(np.eye(n), T_K)
    T = np.linalg.inv(np.linalg.cholesky(rest.T @ P @ rest)).T
    fitted = []
    for near in fits:
        F = np.array([problem.K_basis(rho) for rho in near])
        wanted = [joined(transformed(_rebuilt(start, rho), T_K)) for rho in near]
        rows = np.array([M.ravel() for M in wanted])
        found = np.linalg.lstsq(F, rows, rcond=None)[0]
        fitted.append(found.reshape(-1, *wanted[0].shape))
    quintic = (0.0,) * len(problem.transitions)
    return Smooth(problem, start, T_K, T, np.array(fitted), None, quintic)


def certified(
    design: Smooth,
    points: Sequence[Sided],
    K: Callable[[Values], System] | None = None,
) -> float:
    """Return the γ that P proves at points; no solver is asked.

    ``K`` gives another controller in scaled units, a table's for example.
    """
    worst = 0.0
    for rho, there in groupby(points, lambda point: point.rho):
        T = design.congruence(rho)
        loop = transformed(design.loop(rho, K and K(rho)), T)
        for P, moving in map(design.storage, there):
            worst = max(worst, gain_of_loop(loop, T.T @ P @ T, T.T @ moving @ T))
    return worst * design.start.units.gain


def rate_bound(
    design: Smooth, points: Sequence[Sided], weighted: Weighted | None = None
) -> float:
    """Return η, the largest ‖dK/dt‖₂ at points, in scaled units and states of K.

    Of two parameters that move both norms are added (6.55).  ``weighted`` bounds the
    closed loop's matrices instead (6.13).  It depends on units and states: compare it
    within one design only.
    """

    def of(rho: Values) -> Matrix:
        if weighted is None:
            return joined(design.controller(rho))
        return weighted.left @ joined(design.loop(rho)) @ weighted.right

    worst = 0.0
    for point in points:
        norms = [np.linalg.norm(change, 2) for change in changes(of, point)]
        worst = max(worst, float(sum(norms)))
    return worst * design.start.units.time


def changes(
    of: Callable[[Values], Matrix], point: Sided, step: float = 1e-6
) -> list[Matrix]:
    """Return the rate (1/s) of a matrix over ρ at a point, per parameter that moves."""
    found: list[Matrix] = []
    for axis, rate in enumerate(point.rate):
        if rate:
            ahead, behind = (
                of(
                    tuple(
                        x + sign * step * rate * (i == axis)
                        for i, x in enumerate(point.rho)
                    )
                )
                for sign in (1, -1)
            )
            found.append((ahead - behind) / (2 * step))
    return found


def joined(K: System) -> Matrix:
    """Return [A B; C D]."""
    return np.block([[K.A, K.B], [K.C, K.D]])


def split(M: Matrix, n: int) -> System:
    """Return the system of order n whose [A B; C D] is M."""
    return System(M[:n, :n], M[:n, n:], M[n:, :n], M[n:, n:])


def _storage(start: Design, rho: Values, rate: Values) -> tuple[Matrix, Matrix]:
    basis, used = start.problem.regions[0].basis, start.used[0]
    Y = used.at(basis.values(rho))
    moving = used.at(start.units.time * basis.slopes(rho, rate))
    return storage(Storage(used.X, Y, moving))


def _rebuilt(start: Design, rho: Values) -> System:
    used, basis = start.used[0], start.problem.regions[0].basis
    plant = start.units.plant(start.problem.plant(rho))
    return controller(plant, used.X, used.at(basis.values(rho)), used.gamma)
