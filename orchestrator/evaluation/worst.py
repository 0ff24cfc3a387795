"""Where in a run an expectation was broken: the worst stretch of its signal.

The trace of a metric is what its figure is made of, in the figure's unit: the
error, the deviation from a contour, from the height of a step or from what is
settled to, or the signal itself.  The worst stretch is the one around the
trace's worst row in which it stays beyond the bound.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.evaluation.compared import taken
from orchestrator.evaluation.metrics import Parameters, factor, in_unit, scaled
from orchestrator.evaluation.motion import contour_error
from orchestrator.evaluation.schema import (
    ContourMetric,
    ErrorMetric,
    Expectation,
    MetricSpec,
    SettlingMetric,
    SineMetric,
    StepMetric,
)
from orchestrator.quantities.quantity import Quantity
from orchestrator.result import Signal

Array: TypeAlias = NDArray[np.float64]
_OF_THE_TRACE = ("peak", "rms", "mean", "mean_abs", "max", "min")


@dataclass(frozen=True)
class Stretch:
    """From ``start`` to ``end`` (s) the trace is beyond the bound; worst ``at`` (s).

    ``trace`` says what is meant by ``value``.
    """

    trace: str
    start: float
    end: float
    at: float
    value: float
    unit: str

    def __str__(self) -> str:
        worst = Quantity(self.value, self.unit)
        return (
            f"{self.trace}: worst from {self.start:.6g} s to {self.end:.6g} s, "
            f"{worst} at {self.at:.6g} s"
        )


@np.errstate(all="ignore")  # what diverges may overflow here
def worst_stretch(
    figure: str,
    spec: MetricSpec,
    expectation: Expectation,
    signals: Mapping[str, Signal],
    parameter: Parameters,
) -> Stretch:
    """Return where the trace behind a figure is furthest beyond its bound.

    Of a settling time it is the last stretch outside the band; of a figure that
    is no value of the trace (a phase, say) the rows above half of the largest.
    """
    name, time, trace, unit = _trace(spec, signals, parameter)
    kind = figure.rpartition(".")[2]
    if kind in ("final", "error"):
        at = float(time[-1])
        return Stretch(name, at, at, at, float(trace[-1]), unit)
    size, level = np.abs(trace), float(np.max(np.abs(trace))) / 2
    worst = int(np.argmax(size))
    if kind in _OF_THE_TRACE:
        signed = kind in ("mean", "max", "min")
        size, level = _beyond(kind, trace if signed else size, expectation, unit)
        worst = int(np.argmax(size))
    elif kind == "overshoot":
        size, level = -np.sign(trace[0]) * trace, 0.0
        worst = int(np.argmax(size))
    elif kind == "settling" and isinstance(spec, StepMetric | SettlingMetric):
        step = isinstance(spec, StepMetric)
        level = spec.band if step else spec.band * float(np.max(size))
        worst = int(np.flatnonzero(size > level)[-1]) if np.any(size > level) else worst
    first, last = _around(size >= min(level, float(size[worst])), worst)
    worst = first + int(np.argmax(size[first : last + 1]))
    start, end, at = (float(time[i]) for i in (first, last, worst))
    return Stretch(name, start, end, at, float(trace[worst]), unit)


def _around(inside: NDArray[np.bool_], place: int) -> tuple[int, int]:
    """Return the first and the last row of the stretch of rows around one."""
    before = np.flatnonzero(~inside[:place])
    after = np.flatnonzero(~inside[place:])
    first = int(before[-1]) + 1 if len(before) else 0
    return first, place + int(after[0]) - 1 if len(after) else len(inside) - 1


def _beyond(
    kind: str, size: Array, expectation: Expectation, unit: str
) -> tuple[Array, float]:
    """Return what is too large where it exceeds a level, and that level."""
    upper, lower = (
        None if b is None else Quantity(b, expectation.unit or unit).to(unit).value
        for b in _bounds(expectation)
    )
    if upper is not None and (lower is None or _value(kind, size) >= upper):
        return size, upper
    assert lower is not None  # an expectation has some bound
    return -size, -lower


def _bounds(e: Expectation) -> tuple[float | None, float | None]:
    """Return the least upper and the greatest lower bound of an expectation."""
    uppers, lowers = [e.below], [e.above]
    if e.near is not None and e.within is not None:
        uppers.append(e.near + e.within)
        lowers.append(e.near - e.within)
    upper = [b for b in uppers if b is not None]
    lower = [b for b in lowers if b is not None]
    return min(upper, default=None), max(lower, default=None)


def _value(kind: str, size: Array) -> float:
    if kind in ("mean", "mean_abs"):
        return float(np.mean(size))
    if kind == "min":
        return float(np.min(size))
    return float(np.sqrt(np.mean(size**2)) if kind == "rms" else np.max(size))


def _trace(
    spec: MetricSpec, signals: Mapping[str, Signal], parameter: Parameters
) -> tuple[str, Array, Array, str]:
    found, name = taken(spec, signals), spec.of
    of = found["of"]
    own = None if isinstance(spec, SineMetric) and spec.against else spec.unit
    trace, unit = scaled(spec, of, parameter, own)
    if isinstance(spec, ErrorMetric):
        trace = scaled(spec, found["against"], parameter, unit)[0] - trace
        name = f"{spec.against} - {spec.of}"
    elif isinstance(spec, SettlingMetric):
        trace = trace - spec.final
        name += f" - {Quantity(spec.final, unit)}" if spec.final else ""
    elif isinstance(spec, StepMetric):
        height = Quantity(in_unit(factor(spec.height, parameter), unit), unit)
        trace, name = trace - height.value, f"{name} - {height}"
    elif isinstance(spec, ContourMetric):
        across, _ = scaled(spec, found["across"], parameter, unit)
        radius = in_unit(factor(spec.size, parameter), unit)
        trace = contour_error(trace, across, spec.shape, radius)
        name = f"{spec.of} and {spec.across} off the {spec.shape}"
    time = of.time
    if spec.window is not None:
        start, end = (float(t) for t in spec.window)
        slack = 1e-12 * max(1.0, abs(end))
        rows = (time >= start - slack) & (time <= end + slack)
        time, trace = time[rows], trace[rows]
    return name, time, trace, unit
