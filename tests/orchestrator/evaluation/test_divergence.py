"""What runs away is named, and what only moves, stands or is large is not."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from orchestrator.evaluation.divergence import divergence
from orchestrator.evaluation.schema import MetricSpec
from orchestrator.quantities.quantity import Quantity
from orchestrator.result import Signal

TIME = np.arange(1001) / 1000
ERROR = {"kind": "error", "of": "plant.x", "against": "source.r"}
STEP = {"kind": "step", "of": "plant.x", "height": "2 mm", "band": 0.1, "unit": "mm"}
CONTOUR = {
    "kind": "contour",
    "of": "source.r",
    "across": "plant.x",
    "shape": "circle",
    "size": "2 mm",
    "unit": "um",
}
PEAK = {"kind": "peak", "of": "plant.x"}


def told(x: Any, metric: dict[str, Any] = PEAK, r: Any = 1.0, unit: str = "mm") -> Any:
    spec: Any = TypeAdapter(MetricSpec).validate_python(metric)
    values = {"plant.x": x, "source.r": r}
    signals = {
        name: Signal(name, TIME, np.broadcast_to(y, TIME.shape).astype(float), unit)
        for name, y in values.items()
    }
    return divergence({"m": spec}, signals, lambda name: Quantity(1.0))


@pytest.mark.parametrize(
    ("metric", "text"),
    [
        (ERROR, "diverged: plant.x passes 1e+06 mm at t = 0.139 s"),
        (STEP, "diverged: plant.x passes 2e+06 mm at t = 0.146 s"),
        (CONTOUR, "diverged: plant.x passes 2e+09 um at t = 0.146 s"),
        (PEAK, "diverged: plant.x passes 1e+15 mm at t = 0.346 s"),
    ],
)
def test_exponential_growth_is_named_where_it_passes_its_limit(
    metric: dict[str, Any], text: str
) -> None:
    growth = np.exp(100 * TIME)
    assert np.log(1e6) / 100 == pytest.approx(0.1382, abs=1e-4)
    assert np.log(1e15) / 100 == pytest.approx(0.3454, abs=1e-4)
    assert told(growth, metric) == text
    assert told(-growth, metric) == text


@pytest.mark.parametrize(
    ("x", "metric", "r"),
    [
        (1e3 * TIME, ERROR, 1.0),  # a thousand times what it follows is only bad
        (TIME, ERROR, 0.0),  # what is to stay at zero gives no scale
        (1e30, PEAK, 0.0),  # a constant grows from nowhere
        (np.where(TIME > 0.6, (TIME - 0.6) ** 3, 0.0), PEAK, 0.0),  # from rest
    ],
)
def test_what_only_moves_or_is_large_has_not_diverged(
    x: Any, metric: dict[str, Any], r: float
) -> None:
    assert told(x, metric, r) is None


def test_an_axis_at_rest_beside_one_that_moves_is_measured_by_that_one() -> None:
    specs: Any = TypeAdapter(dict[str, MetricSpec]).validate_python(
        {"x": ERROR, "y": {"kind": "error", "of": "plant.y", "against": "source.q"}}
    )
    rows = {
        "plant.x": TIME,
        "source.r": TIME,
        "plant.y": 1e-3 * TIME,
        "source.q": 6e-17 * TIME,
    }
    signals = {name: Signal(name, TIME, y, "mm") for name, y in rows.items()}
    assert divergence(specs, signals, lambda name: Quantity(1.0)) is None


def test_a_search_for_the_limit_of_stability_may_pass_it() -> None:
    onset = {"kind": "onset", "of": "plant.x", "ramp": "source.r"}
    assert told(np.exp(100 * TIME), onset) is None


def test_units_a_foreign_fmu_made_up_count_as_they_are() -> None:
    text = "diverged: plant.x passes 1e+12 furlongs? at t = 0.277 s"
    assert told(np.exp(100 * TIME), unit="furlongs?") == text
