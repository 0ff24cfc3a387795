"""A smooth-switching design as a data file: its table, and what certifies it.

The table is over the scheduling parameters as of ``table``; ``design`` holds γ after
each step, K and P of ``smooth`` with their states, and the table's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from controllers.synthesis.lpv import shipped
from controllers.synthesis.lpv.problem import Values
from controllers.synthesis.lpv.smooth import Smooth, certified, rate_bound
from controllers.synthesis.lpv.switching import Sided
from controllers.synthesis.lpv.systems import System, continuous, transformed, tustin
from controllers.synthesis.lpv.table import (
    Table,
    balancing_states,
    points_of,
    tabulated,
)


def text(
    found: Smooth,
    names: Sequence[str],
    axes: Sequence[Sequence[float]],
    T_s: float,
    dense: Sequence[Sided],
    weights: Mapping[str, Any] | None = None,
    tried: Sequence[tuple[float, float]] = (),
) -> str:
    """Return the file.

    Args:
        found: the design.
        names, axes: of the scheduling parameters, and the table's breakpoints.
        T_s: sample time (s).
        dense: points on which γ is judged.
        weights: what the problem was made of, for the run-time controller and reader.
        tried: γ_d of a bisection, and what γ the descent came to.
    """
    units = found.start.units
    plain = [
        tustin(units.controller(found.controller(r)), T_s) for r in points_of(axes)
    ]
    balance = balancing_states(plain)
    table = tabulated([transformed(K, balance) for K in plain], axes, T_s)
    about = {
        "gamma": found.history[-1],
        "dense": certified(found, dense),
        **({"weights": dict(weights)} if weights else {}),
        "history": list(found.history),
        **({"gamma_d": [list(pair) for pair in tried]} if tried else {}),
        "transitions": [list(t) for t in found.problem.transitions],
        "free": list(found.free),
        "decay": found.problem.decay,
        "rate_bound": rate_bound(found, _bounded(found, dense)),
        "versions": shipped.versions(),
        "balance": balance,
        "T_K": found.T_K,
        "T": found.T,
        "K": found.K,
        "P": found.P,
    }
    breakpoints = dict(zip(names, table.axes, strict=True))
    content = shipped.sampled(table.system, T_s) | breakpoints | {"design": about}
    return shipped.text(content)


def read(content: Mapping[str, Any], begun: Smooth) -> Smooth:
    """Return the design of a file; ``begun`` tells problem and start."""
    about = content["design"]
    return replace(
        begun,
        T_K=np.array(about["T_K"]),
        T=np.array(about["T"]),
        K=np.array(about["K"]),
        P=None if about["P"] is None else np.array(about["P"]),
        free=tuple(about.get("free", begun.free)),
        history=tuple(about["history"]),
    )


def verified(
    content: Mapping[str, Any],
    begun: Smooth,
    names: Sequence[str],
    dense: Sequence[Sided],
) -> dict[str, float]:
    """Return γ of the blend and of its table, and η before and after; no solver."""
    found, units = read(content, begun), begun.start.units
    back = np.linalg.inv(np.array(content["design"]["balance"]))
    table = Table(
        tuple(np.array(content[name]) for name in names),
        float(Fraction(content["period"])),
        System(*(np.array(content[name]) for name in "ABCD")),
    )

    def tabulated_K(rho: Values) -> System:
        return transformed(units.scaled(continuous(table.at(rho), table.T_s)), back)

    bounded = _bounded(found, dense)
    return {
        "dense": certified(found, dense),
        "table": certified(found, dense, tabulated_K),
        "eta_begun": rate_bound(begun, bounded),
        "eta": rate_bound(found, bounded),
    }


def _bounded(design: Smooth, dense: Sequence[Sided]) -> tuple[Sided, ...]:
    return design.problem.bounded((*design.problem.points, *dense))
