"""Designs as data files: what a run-time controller reads, and what proves it.

A file of JSON holds ``period``, the breakpoints under their names, ``A``, ``B``,
``C``, ``D`` (read by the controller), and ``design``: γ, dense γ, the grid, weights,
versions of the solver, units, X, Y and the states of the table.  Numbers have 12
digits; the verdict of a design read back includes that rounding.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates
from controllers.synthesis.lpv.design import (
    AnyTable,
    Design,
    Verdict,
    design,
    verify,
)
from controllers.synthesis.lpv.fourier import Fourier
from controllers.synthesis.lpv.problem import Found, Point, Problem
from controllers.synthesis.lpv.systems import System
from controllers.synthesis.lpv.table import Table

DIGITS = 12
SOLVERS = ("clarabel", "cvxpy", "numpy", "scipy")


def contents(
    found: Design,
    region: int,
    names: Sequence[str],
    verdict: Verdict,
    weights: Mapping[str, Any],
) -> dict[str, Any]:
    """Return what the file of one region holds.

    Args:
        names: of the scheduling parameters.
        verdict: of the design.
        weights: what the problem was made of, for the reader.
    """
    problem, table = found.problem, found.tables[region]
    best, used = found.best[region], found.used[region]
    axes = dict(zip(names, table.axes, strict=False))
    grid = [point.rho for point in problem.regions[region].points]
    about = {
        "gamma": verdict.gamma,
        "gamma_used": used.gamma * found.units.gain,
        "dense": verdict.dense[region],
        "table": verdict.table[region],
        "weights": dict(weights),
        "decay": problem.decay,
        "grid": grid,
        "versions": versions(),
        "time": found.units.time,
        "gain": found.units.gain,
        "u": found.units.u,
        "y": found.units.y,
        "T": found.units.T,
        "balance": found.balance,
        "best_gamma": best.gamma,
        "best_X": best.X,
        "best_Y": best.Y,
        "used_gamma": used.gamma,
        "X": used.X,
        "Y": used.Y,
    }
    return sampled(table.system, table.T_s) | axes | {"design": about}


def make(
    problem: Problem,
    dense: tuple[tuple[Point, ...], ...],
    names: Sequence[str],
    files: Sequence[str],
    weights: Mapping[str, Any],
) -> dict[str, str]:
    """Solve a problem and return its files, one per region, as text.

    Args:
        problem: what is designed.
        dense: grids per region on which the design is judged.
        names: of the scheduling parameters.
        files: names of the regions' files.
        weights: what the problem was made of, for the reader.
    """
    found = rounded(design(problem))
    judged = verify(found, dense)
    return {
        file: text(contents(found, region, names, judged, weights))
        for region, file in enumerate(files)
    }


def sampled(system: System, T_s: float) -> dict[str, Any]:
    """Return the part that the run-time controller reads."""
    period = str(Fraction(T_s).limit_denominator(10**7))
    return {"period": period} | system._asdict()


def read(
    problem: Problem, files: Sequence[Mapping[str, Any]], names: Sequence[str]
) -> Design:
    """Return the design whose regions' files these are; ``problem`` is not in them."""
    about = [file["design"] for file in files]
    first = about[0]
    units = Coordinates(
        np.array(first["T"]),
        first["time"],
        np.array(first["u"]),
        np.array(first["y"]),
        first["gain"],
    )
    best = [
        Found(d["best_gamma"], np.array(d["best_X"]), np.array(d["best_Y"]))
        for d in about
    ]
    used = [Found(d["used_gamma"], np.array(d["X"]), np.array(d["Y"])) for d in about]
    tables = [_table(problem, file, names) for file in files]
    return Design(
        problem,
        units,
        tuple(best),
        tuple(used),
        np.array(first["balance"]),
        tuple(tables),
    )


def _table(problem: Problem, file: Mapping[str, Any], names: Sequence[str]) -> AnyTable:
    T_s = float(Fraction(file["period"]))
    system = System(*(np.array(file[name]) for name in "ABCD"))
    if problem.order:
        return Fourier(T_s, system)
    return Table(tuple(np.array(file[name]) for name in names), T_s, system)


def rounded(given: Design) -> Design:
    """Return the design with the numbers that its files will hold."""

    def short(value: Any) -> Any:
        return np.array(json.loads(json.dumps(_plain(value))))

    units = replace(given.units, **{n: short(getattr(given.units, n)) for n in "Tuy"})
    tables = tuple(
        replace(table, system=System(*map(short, table.system)))
        for table in given.tables
    )

    def short_of(f: Found) -> Found:
        return Found(float(short(f.gamma)), short(f.X), short(f.Y))

    return replace(
        given,
        units=units,
        best=tuple(map(short_of, given.best)),
        used=tuple(map(short_of, given.used)),
        balance=short(given.balance),
        tables=tables,
    )


def text(content: Mapping[str, Any]) -> str:
    """Return the file: one line per number, matrix or table entry."""

    def lines(mapping: Mapping[str, Any], indent: str) -> str:
        rows = []
        for key, value in mapping.items():
            if isinstance(value, Mapping):
                shown = lines(value, indent + "  ")
            else:
                shown = _matrix(_plain(value), indent + "  ")
            rows.append(f"{indent}  {json.dumps(key)}: {shown}")
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"

    return lines(content, "") + "\n"


def versions() -> dict[str, str]:
    """Return the versions of what a design is made with, as far as installed."""
    found = {}
    for name in SOLVERS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def _matrix(value: Any, indent: str) -> str:
    if isinstance(value, list) and value and isinstance(value[0], list):
        inner = (",\n" + indent + "  ").join(_matrix(v, indent + "  ") for v in value)
        return f"[\n{indent}  {inner}\n{indent}]"
    return json.dumps(value)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}")
    return value
