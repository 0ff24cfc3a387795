"""A scenario's ``[tolerances]`` as distributions, and which of them matters.

Indices of sensitivity are Sobol's, of a sampling of their own (Saltelli et al.
2010, as SciPy carries it out): the share of a figure's variance that a value
explains alone, and with all it interacts with.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.analysis.variations import Assignment, Tolerance
from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import parse_quantity
from orchestrator.scenario.compose import Composition

FloatArray = NDArray[np.float64]
Rows = Callable[[Sequence[Assignment]], Sequence[Any]]


@dataclass(frozen=True)
class Sensitivity:
    """Indices of a figure, one per key: first order and total."""

    figure: str
    first: tuple[float, ...]
    total: tuple[float, ...]


def tolerances_of(composition: Composition) -> list[Tolerance]:
    """Return the tolerances of a composed scenario, in the units of its variables.

    Raises:
        ScenarioError: a number cannot be read, a spread is not positive, or a share
            is of zero.
    """
    found = []
    for key, spec in composition.scenario.spec.tolerances.items():
        where = f'tolerances."{key}"'
        if spec.around is not None:
            nominal = composition.parameter(key).value
            if nominal == 0:
                raise ScenarioError(
                    f"{where}: {key} is 0, of which every percentage is 0; write "
                    f"{{ uniform = [a, b] }} or {{ normal = [mean, deviation] }}"
                )
            ends = nominal * (1 - spec.around), nominal * (1 + spec.around)
            found.append(Tolerance(key, "uniform", min(ends), max(ends)))
        elif spec.uniform is not None:
            a, b = (_number(composition, key, where, v) for v in spec.uniform)
            if not a < b:
                raise ScenarioError(f"{where}: uniform from {a:g} to {b:g} is no range")
            found.append(Tolerance(key, "uniform", a, b))
        elif spec.normal is not None:
            mean, sd = (_number(composition, key, where, v) for v in spec.normal)
            if not sd > 0:
                raise ScenarioError(f"{where}: a standard deviation of {sd:g}")
            found.append(Tolerance(key, "normal", mean, sd))
    return found


def _number(
    composition: Composition, key: str, where: str, written: float | str
) -> float:
    if not isinstance(written, str):
        return written
    try:
        quantity = parse_quantity(written)
    except ValueError as error:
        raise ScenarioError(f"{where}: {error}") from None
    if quantity.unit == "1":
        return quantity.value
    return quantity.to(composition.unit(key)).value


def sensitivities(
    tolerances: Sequence[Tolerance], n: int, seed: int, rows: Rows
) -> list[Sensitivity]:
    """Return Sobol's indices of every figure, from n (2 + number of keys) members.

    ``rows`` carries out assignments and returns rows as those of ``Sweep``.

    Raises:
        ScenarioError: n is no power of two, or a member has no figures.
    """
    from scipy.stats import sobol_indices

    if n < 2 or n & (n - 1):
        raise ScenarioError(f"--sensitivity {n}: write a power of two, such as 1024")
    keys = [t.key for t in tolerances]
    names: list[str] = []

    def outputs(x: FloatArray) -> FloatArray:
        assignments = [dict(zip(keys, column, strict=True)) for column in x.T.tolist()]
        done = rows(assignments)
        failed = next((row for row in done if row["failure"]), None)
        if failed is not None:
            raise ScenarioError(
                f"--sensitivity: a member fails ({failed['failure']}); narrow the "
                f"tolerances"
            )
        if not names:
            skip = {"member", "met", "broken", "failure", *keys}
            names.extend(k for k, v in done[0].items() if k not in skip and v == v)
        columns = [[row[name] for name in names] for row in done]
        if any(v is None for row in columns for v in row):
            raise ScenarioError("--sensitivity: a figure has no value in some members")
        return np.array(columns, dtype=float).T

    with np.errstate(invalid="ignore", divide="ignore"):
        found = sobol_indices(
            func=outputs,
            n=n,
            dists=[t.distribution() for t in tolerances],
            rng=np.random.default_rng(seed),
        )
    first, total = np.atleast_2d(found.first_order), np.atleast_2d(found.total_order)
    return [
        Sensitivity(name, tuple(first[i].tolist()), tuple(total[i].tolist()))
        for i, name in enumerate(names)
    ]
