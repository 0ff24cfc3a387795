"""What a scenario expects of its curves: levels that figures are to keep.

Only figures that are a value of the curve have a level in its panel: ``peak`` one
on each side, ``max``, ``min``, ``mean``, ``rms`` and ``final`` their own.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from orchestrator.evaluation.metrics import factors
from orchestrator.evaluation.schema import Expectation, MetricSpec
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import unit_of

if TYPE_CHECKING:
    from orchestrator.outcome import Run

LEVELS = ("peak", "max", "min", "mean", "rms", "final")


class Limit(NamedTuple):
    """A level in the unit of a panel, and what it says."""

    value: float
    label: str


def limits(run: "Run", metric: str, unit: str, *, of_signal: bool) -> Iterator[Limit]:
    """Yield the levels that a metric's figures are to keep, in a panel's unit.

    ``of_signal``: the panel shows the signal itself, without the metric's factors.
    """
    spec = run.scenario.spec
    for name, expected in spec.expect.items():
        owner, _, kind = name.rpartition(".")
        if owner != metric or kind not in LEVELS or name not in run.metrics:
            continue
        figure = unit_of(run.metrics[name].unit)
        own = unit_of(expected.unit or figure).of_difference(figure.relative)
        for word, level in _bounds(expected):
            quantity = Quantity(level, own)
            said = f"{name} {word} {quantity}"
            if of_signal:
                quantity = _without_factors(quantity, spec.metrics[metric], run)
            value = quantity.to(unit).value
            yield Limit(value, said)
            if kind == "peak":
                yield Limit(-value, said)


def _bounds(e: Expectation) -> Iterator[tuple[str, float]]:
    if e.below is not None:
        yield "below", e.below
    if e.above is not None:
        yield "above", e.above
    if e.near is not None and e.within is not None:
        yield "at most", e.near + e.within
        yield "at least", e.near - e.within


def _without_factors(figure: Quantity, spec: MetricSpec, run: "Run") -> Quantity:
    """Return what the signal itself is where a figure of it has a value."""
    unit = run[spec.of].unit
    total = factors(spec, unit, run.composition.parameter)
    return Quantity(figure.to(total.unit).value / total.value, unit)
