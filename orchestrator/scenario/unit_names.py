"""Unit names in ``[metrics]`` and ``[expect]``, read as the FMUs at hand define them.

What of a conversion is a guess is warned of here, before the run.
"""

from collections.abc import Callable, Mapping
from typing import Any

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.evaluation.metrics import Parameters, unit_doubts
from orchestrator.evaluation.schema import Expectation, Factor, MetricSpec
from orchestrator.fmu.description import FmuDescription
from orchestrator.quantities.quantity import Quantity, parse_quantity
from orchestrator.quantities.unit import Unit, UnitNames, conversion
from orchestrator.scenario.schema import Specification
from orchestrator.system import split_name
from orchestrator.warned import warn

MAGNITUDES = ("peak", "rms")  # of a value with an offset they do not convert


def read_units(
    spec: Specification,
    fmus: Mapping[str, FmuDescription],
    unit: Callable[[str], Unit],
    parameter: Parameters,
) -> Specification:
    """Return a scenario whose metrics and expectations hold defined units.

    ``unit`` returns that of ``component.variable``, ``parameter`` as for ``evaluate``.

    Raises:
        ScenarioError: a unit is none, or is defined in several ways; a magnitude of
            values with an offset is to be converted.
    """
    reader = _Reader(fmus, unit)
    metrics = {name: reader.metric(name, m) for name, m in spec.metrics.items()}
    expect = {
        name: reader.expectation(name, e, spec.metrics)
        for name, e in spec.expect.items()
    }
    read = spec.model_copy(update={"metrics": metrics, "expect": expect})
    _warn_of_guesses(read, unit, parameter)
    return read


class _Reader:
    """Reads the unit names of one scenario beside the signals they are about."""

    def __init__(
        self, fmus: Mapping[str, FmuDescription], unit: Callable[[str], Unit]
    ) -> None:
        self._names = UnitNames({name: fmu.units for name, fmu in fmus.items()})
        self._unit = unit

    def metric(self, name: str, metric: MetricSpec) -> MetricSpec:
        found: dict[str, Any] = {}
        for key, field in type(metric).model_fields.items():
            written = getattr(metric, key)
            where = f"metrics.{name}.{key}"
            if field.annotation == Factor and isinstance(written, str):
                if not (written[:1].isalpha() or written.startswith("_")):
                    found[key] = self._quantity(where, written, metric.of)
            elif key == "unit" and written is not None:
                found[key] = self._read(where, written, metric.of)
        return metric.model_copy(update=found)

    def expectation(
        self, name: str, expectation: Expectation, metrics: Mapping[str, MetricSpec]
    ) -> Expectation:
        metric = metrics.get(name.rpartition(".")[0])
        if expectation.unit is None or metric is None:
            return expectation
        unit = self._read(f'expect."{name}"', expectation.unit, metric.of)
        return expectation.model_copy(update={"unit": unit})

    def _quantity(self, where: str, written: str, beside: str) -> Quantity:
        try:
            quantity = parse_quantity(written)
        except ValueError as error:
            raise ScenarioError(f"{where}: {error}") from None
        return Quantity(quantity.value, self._read(where, quantity.unit, beside))

    def _read(self, where: str, text: str, beside: str) -> Unit:
        try:
            like = self._unit(beside)
        except ScenarioError:  # refused with the metric itself
            like = None
        try:
            return self._names.unit(text, split_name(beside)[0], like)
        except UnitError as error:
            raise ScenarioError(f"{where}: {error}") from None


def _warn_of_guesses(
    spec: Specification, unit: Callable[[str], Unit], parameter: Parameters
) -> None:
    """Warn of every conversion in metrics and expectations that is a guess.

    What does not convert at all is refused where the metric is.

    Raises:
        ScenarioError: a magnitude of values with an offset is to be converted.
    """
    for name, metric in spec.metrics.items():
        try:
            for doubt in unit_doubts(metric, unit, parameter):
                warn(f"metrics.{name}: {doubt}")
        except (ScenarioError, UnitError):
            continue
    for name, expectation in spec.expect.items():
        metric_name, _, figure = name.rpartition(".")
        about = spec.metrics.get(metric_name)
        if about is None or not expectation.unit:
            continue
        try:
            own = about.unit or unit(about.of)
            _, offset, doubts = conversion(own, expectation.unit)
        except (ScenarioError, UnitError):
            continue
        for doubt in doubts:
            warn(f'expect."{name}": {doubt}')
        if offset and about.kind == figure and figure in MAGNITUDES:
            raise ScenarioError(
                f'expect."{name}": the {figure} of values in {own} says '
                f"nothing in {expectation.unit}; give metrics.{metric_name} that unit"
            )
