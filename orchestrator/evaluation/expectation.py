"""Whether the figures of a run keep the bounds its scenario expects."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fmus.units import UnitError
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Expectation
from orchestrator.quantities.quantity import NoValue, Quantity


@dataclass(frozen=True)
class Check:
    """One expectation: the figure it is about, whether it is met, in words.

    ``decided`` is false if the run does not have the figure; then it is not met.
    """

    figure: str
    met: bool
    text: str
    decided: bool = True


def check(
    expectations: Mapping[str, Expectation], figures: Mapping[str, Quantity]
) -> list[Check]:
    """Return for each expectation whether it is met.

    Raises:
        ScenarioError: it names no figure there is, or its unit does not fit.
    """
    return [_check(name, e, figures) for name, e in expectations.items()]


def _check(name: str, e: Expectation, figures: Mapping[str, Quantity]) -> Check:
    if name not in figures:
        remedy = did_you_mean(name, figures)
        raise ScenarioError(f'expect."{name}": there is no such figure; {remedy}')
    try:
        value = figures[name].to(e.unit)
    except UnitError as error:
        raise ScenarioError(f'expect."{name}": {error}') from None
    wanted = []
    met = np.isfinite(value.value)
    if e.below is not None:
        wanted.append(f"below {e.below:g}")
        met &= value.value < e.below
    if e.above is not None:
        wanted.append(f"above {e.above:g}")
        met &= value.value > e.above
    if e.near is not None and e.within is not None:
        wanted.append(f"{e.near:g} within {e.within:g}")
        met &= abs(value.value - e.near) <= e.within
    unit = "" if e.unit in (None, "1") else f" {e.unit}"
    expected = f"expected {' and '.join(wanted)}{unit}"
    if isinstance(value, NoValue):
        return Check(name, False, f"{name}: {value}; {expected}", decided=False)
    return Check(name, bool(met), f"{name} = {value}, {expected}")
