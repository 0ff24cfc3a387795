"""The worst stretch of a signal is where its expectation was broken."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from orchestrator.evaluation.schema import Expectation, MetricSpec
from orchestrator.evaluation.worst import worst_stretch
from orchestrator.quantities.quantity import Quantity
from orchestrator.result import Signal

T = np.arange(1001) / 1000
TWO_PEAKS = np.where((T > 0.2) & (T < 0.3), 2.0, 0.0) - np.where(
    (T > 0.6) & (T < 0.65), 5.0, 0.0
)


def find(figure: str, metric: dict[str, Any], expected: dict[str, Any]) -> Any:
    signals = {
        "a.y": Signal("a.y", T, TWO_PEAKS, "mm"),
        "a.r": Signal("a.r", T, np.zeros_like(T), "mm"),
    }
    spec: Any = TypeAdapter(MetricSpec).validate_python({"of": "a.y", **metric})
    bound = Expectation.model_validate(expected)
    return worst_stretch(f"m.{figure}", spec, bound, signals, lambda n: Quantity(1.0))


@pytest.mark.parametrize(
    ("kind", "expected", "start", "end", "value"),
    [
        ("peak", {"below": 1.0}, 0.601, 0.649, -5.0),
        ("max", {"below": 1.0}, 0.201, 0.299, 2.0),
        ("min", {"above": -1.0}, 0.601, 0.649, -5.0),
        ("peak", {"below": 1e-3, "unit": "m"}, 0.601, 0.649, -5.0),
        ("mean", {"near": -1.0, "within": 0.1}, 0.0, 0.6, 2.0),
        ("final", {"above": 1.0}, 1.0, 1.0, 0.0),
    ],
)
def test_the_stretch_beyond_the_bound_is_found(
    kind: str, expected: dict[str, Any], start: float, end: float, value: float
) -> None:
    found = find(kind, {"kind": kind}, expected)
    assert (found.start, found.end, found.value) == (start, end, value)
    assert found.start <= found.at <= found.end


def test_an_error_is_named_by_both_signals_and_signed() -> None:
    metric = {"kind": "error", "against": "a.r", "unit": "um"}
    found = find("peak", metric, {"below": 1000.0})
    assert str(found).startswith("a.r - a.y: worst from 0.601 s to 0.649 s, 5000 um at")


def test_a_window_leaves_out_what_is_outside() -> None:
    metric = {"kind": "peak", "window": ["0", "0.5"]}
    assert find("peak", metric, {"below": 1.0}).value == 2.0


def test_settling_shows_the_last_time_outside_the_band() -> None:
    metric = {"kind": "step", "height": 1.0, "band": 1.5}
    found = find("settling", metric, {"below": 0.1, "unit": "s"})
    assert (found.start, found.end) == (0.601, 0.649)
