"""Lines of a report that are drawn beside curves: contours, levels expected."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import special

from orchestrator.evaluation.motion import contour_error
from orchestrator.evaluation.schema import Expectation
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import unit_of
from orchestrator.report.contour import Traced, outline
from orchestrator.report.limits import limits

LENGTHS = {  # of contours of size 1; the rose by a complete elliptic integral
    "circle": 2 * np.pi,
    "diamond": 4 * np.sqrt(2),
    "rose": 8 * special.ellipe(0.75),
    "square": 4.0,
}


@pytest.mark.parametrize("shape", LENGTHS)
def test_the_contour_drawn_is_the_one_that_errors_are_measured_from(shape: str) -> None:
    none = np.zeros(0), np.zeros(0)
    path = Traced("", "", ("x", "y"), shape, 50.0, "mm", none, none, none[0], 0)
    x, y = outline(path)
    assert np.max(np.abs(contour_error(x, y, shape, 50.0))) < 1e-12
    length = np.sum(np.hypot(np.diff(x), np.diff(y)))
    assert length == pytest.approx(50 * LENGTHS[shape], rel=1e-4)


def test_a_level_in_kelvin_of_a_difference_of_temperatures_is_a_difference() -> None:
    difference = unit_of("degC").of_difference()
    spec = SimpleNamespace(expect={"lag.peak": Expectation(below=2.0, unit="K")})
    run = SimpleNamespace(
        scenario=SimpleNamespace(spec=spec),
        metrics={"lag.peak": Quantity(1.0, difference)},
    )
    found = limits(run, "lag", difference, of_signal=False)  # type: ignore[arg-type]
    assert [level.value for level in found] == pytest.approx([2.0, -2.0])
