"""Parameters of a scenario's models fitted to measured data.

Every signal that is compared counts by the noise it turns out to have: weighted first
by its own range, then by what the fit before left of it.  The last part of the rows is
not used, but run and compared: what holds there was not merely adapted to.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orchestrator.analysis import heir
from orchestrator.analysis.estimate import Estimate, estimate, lag_1
from orchestrator.analysis.measured import Measured
from orchestrator.analysis.members import refuse_driven, split
from orchestrator.errors import FitError
from orchestrator.scenario.compose import Composition
from orchestrator.system import Value, split_name

Bracket = tuple[float, float]

REACH = 10.0  # times and parts of its start value a value may become unasked
ROUNDS = 4  # of weighting at most
SETTLED = 0.01  # of a weight
TOLD = 0.95  # of a correlation between two values, that is told
WHITE = 0.2  # of a correlation from row to row, that is told
WORSE = 1.5  # times the residual on rows not used, that is told


@dataclass(frozen=True)
class Free:
    """A value that is fitted: ``component.variable``, its start, bracket and unit."""

    name: str
    start: float
    bracket: Bracket
    unit: str


@dataclass(frozen=True)
class Fit:
    """What came of a fit; arrays by signal are (rows,), in the unit of the signal.

    ``rms`` and ``rms_unused`` are of the residuals on the rows used and on the others
    (None if there are none); ``words`` what their reader has to know; ``designs`` the
    steps that set something of what ran.
    """

    free: tuple[Free, ...]
    found: Estimate
    time: NDArray[np.float64]
    used: int
    measured: Mapping[str, NDArray[np.float64]]
    simulated: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str]
    rms: Mapping[str, float]
    rms_unused: Mapping[str, float | None]
    words: tuple[str, ...]
    designs: tuple[str, ...] = ()

    def values(self) -> dict[str, dict[str, object]]:
        """Return value, standard error and unit by name, as ``fit --json`` prints."""
        pairs = zip(self.found.values, self.found.standard_errors, strict=True)
        return {
            free.name: {
                "value": float(value),
                "standard_error": float(error),
                "unit": free.unit,
            }
            for free, (value, error) in zip(self.free, pairs, strict=True)
        }


def free_values(
    composition: Composition,
    names: Sequence[str],
    brackets: Mapping[str, Bracket],
    about: Mapping[str, float] | None = None,
) -> tuple[Free, ...]:
    """Return what is to be fitted, with brackets as given or about the start values.

    A bracket given, or about a value of ``about``, need hold that value only.

    Raises:
        FitError: a name is no real parameter or start value, or its bracket does not
            hold its start value.
        ScenarioError: a connection drives it.
    """
    if unknown := [name for name in brackets if name not in names]:
        raise FitError(f"--bounds {unknown[0]}: it is not among --free")
    refuse_driven(composition, "--free", names)
    return tuple(
        _free(composition, name, brackets.get(name), (about or {}).get(name))
        for name in names
    )


def _free(
    composition: Composition,
    name: str,
    given: Bracket | None,
    about: float | None,
) -> Free:
    component, variable = split_name(name)
    if (
        component not in composition.system.components
        or split(composition, {name: 0.0})[1]
    ):
        raise FitError(f"--free {name}: is no real parameter or start value")
    quantity = composition.parameter(name)
    start, (low, high) = quantity.value, given or (0.0, 0.0)
    if given is None:
        if start == 0:
            raise FitError(
                f"--free {name}: starts at 0 {quantity.unit}, which says nothing of "
                f"its size; give a bracket, --bounds {name}=LOW:HIGH"
            )
        low, high = sorted((start / REACH, start * REACH))
        described = composition.fmus[component].variables.get(variable)
        if (
            described is not None
            and variable not in composition.system.components[component].map
        ):
            low = max(low, _finite(described.min, low))
            high = min(high, _finite(described.max, high))
    held = start if about is None else about
    if not low <= held <= high or low == high:
        raise FitError(
            f"--bounds {name}={low:g}:{high:g}: does not hold the start value {held:g}"
        )
    return Free(name, start, (low, high), str(quantity.unit))


def _finite(bound: str | None, other: float) -> float:
    return float(bound) if bound is not None and isfinite(float(bound)) else other


def fit(
    composition: Composition,
    measured: Measured,
    free: Sequence[Free],
    unused: float = 0.25,
) -> Fit:
    """Fit values to measured rows; the last ``unused`` share of them is left out.

    Raises:
        FitError: nothing to fit, or the rows do not tell the values.
        SimulationError: a model failed at values within their brackets.
    """
    names = tuple(f.name for f in free)
    if not names:
        raise FitError("name the values to fit, --free plant.m_2,plant.b_1")
    used = measured.rows - int(unused * measured.rows)
    start = np.array([f.start for f in free])
    brackets = np.array([f.bracket for f in free])
    target = measured.compared
    weights = {name: float(np.ptp(y[:used])) or 1.0 for name, y in target.items()}
    with measured.series() as series:

        def simulated(x: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
            return measured.run(series, assigned(names, x))

        def residuals(x: NDArray[np.float64]) -> NDArray[np.float64]:
            model = simulated(x)
            parts = [(model[n] - y)[:used] / weights[n] for n, y in target.items()]
            return np.concatenate(parts)

        for _ in range(ROUNDS):
            found = estimate(residuals, start, brackets, names)
            left = found.residuals.reshape(len(target), used)
            sizes = np.sqrt(np.mean(left**2, axis=1))
            start = found.values
            even = np.ptp(sizes) <= SETTLED * np.max(sizes)
            if even or not np.all(sizes > 0):
                break
            for name, size in zip(target, sizes, strict=True):
                weights[name] *= float(size)
        model = simulated(found.values)
    apart = {name: model[name] - y for name, y in target.items()}
    rms = {name: _rms(e[:used]) for name, e in apart.items()}
    others = {
        name: _rms(e[used:]) if used < measured.rows else None
        for name, e in apart.items()
    }
    steps = composition.scenario.spec.design.items()
    ran = measured.system.components
    designs = tuple(name for name, step in steps if any(c in ran for c in step.sets))
    return Fit(
        tuple(free),
        found,
        measured.time,
        used,
        target,
        model,
        {name: str(composition.unit(name)) for name in target},
        rms,
        others,
        (
            *_words(free, found, {n: e[:used] for n, e in apart.items()}, rms, others),
            *heir.words(composition, names, designs),
        ),
        designs,
    )


def assigned(
    names: Sequence[str], x: Sequence[float] | NDArray[np.float64]
) -> dict[str, dict[str, Value]]:
    """Return values by component and variable."""
    values: dict[str, dict[str, Value]] = {}
    for name, value in zip(names, x, strict=True):
        component, variable = split_name(name)
        values.setdefault(component, {})[variable] = float(value)
    return values


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _words(
    free: Sequence[Free],
    found: Estimate,
    apart: Mapping[str, NDArray[np.float64]],
    rms: Mapping[str, float],
    others: Mapping[str, float | None],
) -> list[str]:
    words = []
    for i, one in enumerate(free):
        if found.at_bound[i]:
            words.append(
                f"{one.name} is at the end of its bracket {one.bracket[0]:g} to "
                f"{one.bracket[1]:g}: its error means nothing, give a wider --bounds"
            )
        for j in range(i):
            if abs(r := found.correlation[i, j]) > TOLD:
                words.append(
                    f"{free[j].name} and {one.name} are hardly told apart: their "
                    f"errors are correlated by {r:+.3f}"
                )
    for name, residual in apart.items():
        if (r := lag_1(residual)) > WHITE:
            words.append(
                f"{name}: its residuals are correlated by {r:+.2f} from row to row: "
                f"the model lacks something, or the noise is coloured; standard errors "
                f"are too small"
            )
        unused = others[name]
        if unused is not None and unused > WORSE * rms[name]:
            words.append(
                f"{name}: on rows not used the residual is {unused / rms[name]:.2g} "
                f"times that on rows used: the fit does not carry over"
            )
    return words


def scenario_of(composition: Composition, found: Fit, data: Path, target: Path) -> Path:
    """Write the scenario that inherits from the fitted one and has the values found.

    A design of what ran in the fit stays as it was then; any other is done anew.
    """
    values = {name: float(str(told["value"])) for name, told in found.values().items()}
    title = f"{composition.scenario.name} fitted to {data.name}"
    return heir.write_heir(composition, values, title, target, found.designs)
