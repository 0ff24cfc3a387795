"""Figures by a function that another package adds (``kind = "plugin"``)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.units import UnitError
from orchestrator.errors import PluginError
from orchestrator.evaluation.schema import PluginMetric
from orchestrator.plugins import load
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import Unit


def of_plugin(
    spec: PluginMetric, time: NDArray[np.float64], y: NDArray[np.float64], unit: Unit
) -> dict[str, Quantity]:
    """Return the figures that a package's function finds in rows (n,) at times (s).

    Raises:
        PluginError: the function failed, or returned no figures with units.
    """
    function = load("metrics", spec.name)
    try:
        found = function(time.copy(), y.copy(), str(unit), **spec.arguments)
    except Exception as error:
        told = f"{type(error).__name__}: {error}"
        raise PluginError(f"the metric {spec.name} failed: {told}") from error
    return _figures(spec.name, found)


def _figures(name: str, found: Any) -> dict[str, Quantity]:
    wrong = f"the metric {name} returned {found!r} instead of {{figure: (value, unit)}}"
    if not isinstance(found, Mapping) or not found:
        raise PluginError(wrong)
    try:
        return {
            str(figure): Quantity(float(value), str(unit))
            for figure, (value, unit) in found.items()
        }
    except (TypeError, ValueError, UnitError) as error:
        raise PluginError(f"{wrong} ({error})") from None
