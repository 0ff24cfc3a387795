"""From a problem to tables of sampled controllers with their certificates."""

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates
from controllers.synthesis.lpv.elimination import NoSolution, eliminate
from controllers.synthesis.lpv.fourier import Fourier, angles, fitted
from controllers.synthesis.lpv.frozen import balanced, frozen_optima, of_control
from controllers.synthesis.lpv.inequalities import Storage, gain_of_loop, storage
from controllers.synthesis.lpv.kept import kept_gain
from controllers.synthesis.lpv.problem import Found, Point, Problem, Region, Values
from controllers.synthesis.lpv.reconstruction import controller
from controllers.synthesis.lpv.systems import (
    Matrix,
    System,
    continuous,
    transformed,
    tustin,
)
from controllers.synthesis.lpv.table import (
    Table,
    balancing_states,
    points_of,
    tabulated,
)

AnyTable: TypeAlias = Table | Fourier


@dataclass(frozen=True)
class Design:
    """Tables per region, and what proves them.

    ``best`` belongs to the smallest γ, tables are built from ``used``; both are in
    ``units``.  The states of all controllers are x_K = ``balance`` x_table.
    """

    problem: Problem
    units: Coordinates
    best: tuple[Found, ...]
    used: tuple[Found, ...]
    balance: Matrix
    tables: tuple[AnyTable, ...]

    @property
    def gamma(self) -> float:
        """The smallest γ of the inequalities on the grid."""
        return self.best[0].gamma * self.units.gain


class Verdict(NamedTuple):
    """What X, Y and tables of a design are found to keep; no solver was asked.

    ``gamma``: the least γ of ``best`` on the design's grid, decay included.
    ``dense``: of ``used`` per region on a dense grid; inf if not certified.
    ``table``: certified for the closed loop with each region's interpolated table.
    ``difference``: largest of a table from the formulas, relative to each entry.
    ``links``: largest eigenvalue of Y_to - Y_of over that of Y_of; ≤ 0 may switch.
    """

    gamma: float
    dense: tuple[float, ...]
    table: tuple[float, ...]
    difference: float
    links: float


def design(problem: Problem, solver: str = "CLARABEL") -> Design:
    """Solve the problem and tabulate its controllers.

    Raises:
        NoSolution: the solver says so, or what it claims is impossible.
        ImportError: the extra ``synthesis`` is not installed.
    """
    told = problem.plant, problem.frozen, problem.time, problem.gain
    if problem.control_alone:
        units, bound = of_control(*told)
    else:
        units, bound = balanced(*told, problem.floors)
    best, used = eliminate(problem, units, solver)
    refuse_below(bound, best[0].gamma * units.gain, solver)
    plain = [
        [
            tustin(_built(problem, units, region, found, rho), problem.T_s)
            for rho in _tabulated_at(problem, axes)
        ]
        for region, found, axes in zip(problem.regions, used, problem.axes, strict=True)
    ]
    balance = balancing_states([K for systems in plain for K in systems])
    tables = tuple(
        _table([transformed(K, balance) for K in systems], problem, axes)
        for systems, axes in zip(plain, problem.axes, strict=True)
    )
    return Design(problem, units, best, used, balance, tables)


def refuse_below(bound: float, gamma: float, solver: str) -> None:
    """Refuse a γ that no controller can keep.

    Raises:
        NoSolution: γ is below the optimum of a plant that stands still.
    """
    if gamma < bound:
        raise NoSolution(
            f"{solver} claims {gamma:.4g}, but a plant of the grid that stands still "
            f"has the H-infinity optimum {bound:.4g}: use another solver"
        )


def lower_bound(problem: Problem) -> float:
    """Return the H-infinity optimum of the worst frozen plant: no γ is below it."""
    optima = frozen_optima(problem.plant, problem.frozen, problem.time, problem.gain)
    return float(np.max(optima))


def verify(design: Design, dense: tuple[tuple[Point, ...], ...]) -> Verdict:
    """Return what a design keeps, on dense grids of its regions.

    The closed loop is that of the continuous plant with the continuous system whose
    Tustin transform the interpolated table is: rounding, interpolation and sampling
    of the table are in it, the hold of the samples is not.
    """
    problem, gain = design.problem, design.units.gain
    rows = list(
        zip(problem.regions, design.best, design.used, design.tables, strict=True)
    )
    gamma = max(
        kept_gain(problem, design.units, region, best, region.points, problem.decay)
        for region, best, _, _ in rows
    )
    checked = [
        kept_gain(problem, design.units, region, used, points)
        for (region, _, used, _), points in zip(rows, dense, strict=True)
    ]
    loops = [
        _loop_gain(design, region, used, table, points)
        for (region, _, used, table), points in zip(rows, dense, strict=True)
    ]
    return Verdict(
        gamma * gain,
        tuple(value * gain for value in checked),
        tuple(value * gain for value in loops),
        max(_difference(design, *row) for row in rows),
        max(_links(design), default=0.0),
    )


def _tabulated_at(
    problem: Problem, axes: tuple[tuple[float, ...], ...]
) -> list[Values]:
    return angles(problem.order) if problem.order else points_of(axes)


def _table(
    systems: list[System], problem: Problem, axes: tuple[tuple[float, ...], ...]
) -> AnyTable:
    if problem.order:
        return fitted(systems, problem.order, problem.T_s)
    return tabulated(systems, axes, problem.T_s)


def _built(
    problem: Problem, units: Coordinates, region: Region, found: Found, rho: Values
) -> System:
    """Return the continuous controller in SI."""
    plant = units.plant(problem.plant(rho))
    Y = found.at(region.basis.values(rho))
    return units.controller(controller(plant, found.X, Y, found.gamma))


def _loop_gain(
    design: Design,
    region: Region,
    found: Found,
    table: AnyTable,
    points: tuple[Point, ...],
) -> float:
    units, worst = design.units, 0.0
    states = np.linalg.inv(design.balance)
    for point in points:
        plant = units.plant(design.problem.plant(point.rho))
        K = units.scaled(continuous(table.at(point.rho), table.T_s))
        loop = plant.close(transformed(K, states))
        Y = found.at(region.basis.values(point.rho))
        for rate in point.rates:
            moving = found.at(units.time * region.basis.slopes(point.rho, rate))
            worst = max(
                worst, gain_of_loop(loop, *storage(Storage(found.X, Y, moving)))
            )
    return worst


def _difference(
    design: Design, region: Region, best: Found, used: Found, table: AnyTable
) -> float:
    rebuilt = [
        transformed(
            tustin(_built(design.problem, design.units, region, used, rho), table.T_s),
            design.balance,
        )
        for rho in table.points
    ]
    worst = 0.0
    for M, N in zip(table.system, table.remade(rebuilt), strict=True):
        floor = 1e-6 * np.max(np.abs(N), axis=(-1, -2), keepdims=True) + 1e-300
        worst = max(worst, float(np.max(np.abs(M - N) / (np.abs(N) + floor))))
    return worst


def _links(design: Design) -> list[float]:
    regions, used = design.problem.regions, design.used
    found = []
    for link in design.problem.links:
        of, to = (
            used[r].at(regions[r].basis.values(link.rho)) for r in (link.of, link.to)
        )
        found.append(
            float(np.linalg.eigvalsh(to - of)[-1] / np.linalg.eigvalsh(of)[-1])
        )
    return found
