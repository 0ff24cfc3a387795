"""Figures of a recorded run, with their units.

Signals are compared row by row at the instants that ``compared`` finds, never
interpolated.  A figure that this run does not have (it
never settled, say) is a ``NoValue`` with its reason, and so is one that is too
large for a number; only what is written wrongly is refused.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import isfinite, isnan
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.evaluation.compared import loses_digits, taken
from orchestrator.evaluation.motion import (
    contour_error,
    onset,
    step_response,
    sustained,
)
from orchestrator.evaluation.plugin import of_plugin
from orchestrator.evaluation.schema import (
    ContourMetric,
    ErrorMetric,
    Factor,
    MetricSpec,
    OnsetMetric,
    PlainMetric,
    PluginMetric,
    SettlingMetric,
    SineMetric,
    SpectrumMetric,
    StepMetric,
    SustainedMetric,
)
from orchestrator.evaluation.sine import Sine
from orchestrator.evaluation.spectrum import spectrum_line, strongest_line
from orchestrator.quantities.quantity import (
    NoValue,
    Quantity,
    converter,
    parse_quantity,
)
from orchestrator.quantities.unit import (
    Unit,
    conversion,
    product_unit,
    quotient_unit,
    refuse_multiple,
    unit_of,
)
from orchestrator.result import End, Signal

Array: TypeAlias = NDArray[np.float64]
Parameters: TypeAlias = Callable[[str], Quantity]


def evaluate(
    specs: Mapping[str, MetricSpec],
    signals: Mapping[str, Signal],
    parameter: Parameters,
    ended: End | None = None,
    begun: Fraction = Fraction(0),
) -> dict[str, Quantity]:
    """Return all figures ``<metric>.<figure>`` of a run.

    ``parameter`` returns the value and unit of a ``component.parameter``.  Metrics have
    no value whose window was not reached, of a run that ``ended`` early or stops before
    the window's last row, and of one that was ``begun`` at a later time than 0 (s)
    none whose window begins before.

    Raises:
        ScenarioError: a signal is not recorded, grids or units do not fit, a
            window holds no row.
    """
    figures = {}
    for name, spec in specs.items():
        try:
            with np.errstate(all="ignore"):  # what overflows has no value
                found = _while(begun, ended, spec, signals, parameter)
            for key, figure in found.items():
                figures[f"{name}.{key}"] = _in_range(figure)
        except (ScenarioError, UnitError) as error:
            raise ScenarioError(f"metrics.{name}: {error}") from None
    return figures


def _while(
    begun: Fraction,
    ended: End | None,
    spec: MetricSpec,
    signals: Mapping[str, Signal],
    parameter: Parameters,
) -> dict[str, Quantity]:
    if name := loses_digits(spec, signals):
        why = f"{name} has more digits than a figure holds (beyond 2^53)"
        found = _figures(spec, signals, parameter)
        return {key: NoValue(figure.unit, why=why) for key, figure in found.items()}
    if spec.window is None:
        return _figures(spec, signals, parameter)
    start, end = spec.window
    if start < begun:
        why = f"its window begins at {float(start):g} s, the run at {float(begun):g} s"
    elif ended is not None and end > ended.at:
        why = f"its window until {float(end):g} s was not reached: {ended}"
    elif (last := _cut(taken(spec, signals)["of"], start, end)) is not None:
        why = (
            f"its window ends at {float(end):g} s, the rows at {last:g} s; set stop to "
            f"{float(end):g} or later"
        )
    else:
        return _figures(spec, signals, parameter)
    whole = spec.model_copy(update={"window": None})  # for the figures' names
    found = _figures(whole, signals, parameter)
    return {key: NoValue(figure.unit, why=why) for key, figure in found.items()}


def _cut(signal: Signal, start: Fraction, end: Fraction) -> float | None:
    """Return the time (s) of the last row if there would be more up to the window's
    end; a window after all rows is refused elsewhere."""
    time = signal.time
    if len(time) < 2 or time[-1] < float(start):
        return None
    following = 2 * time[-1] - time[-2]
    slack = 1e-6 * (time[-1] - time[-2])
    return float(time[-1]) if following <= float(end) + slack else None


def _in_range(figure: Quantity) -> Quantity:
    if isinstance(figure, NoValue) or isfinite(figure.value):
        return figure
    why = "not a number" if isnan(figure.value) else "too large for a number"
    return NoValue(figure.unit, why=why)


def scaled(
    spec: MetricSpec, signal: Signal, parameter: Parameters, to_unit: str | None
) -> tuple[Array, Unit]:
    """Return a signal's values (n,) with a metric's factors in a unit, and that unit.

    Without ``to_unit`` the unit is that of signal * scale / per.
    """
    total = factors(spec, signal.unit, parameter)
    if total.value != 1 and not _of_difference(spec):
        refuse_multiple(f"scale or per, {total.value:g}", unit_of(total.unit))
    values, own = signal.values * total.value, unit_of(total.unit)
    if to_unit is None:
        return values, own
    wanted = own if to_unit == own and not isinstance(to_unit, Unit) else to_unit
    unit = unit_of(wanted).of_difference(own.relative)
    return converter(own, unit)(values), unit


def _of_difference(spec: MetricSpec) -> bool:
    """Tell whether all figures of a metric are differences of values."""
    kinds = ErrorMetric | ContourMetric | SineMetric | SpectrumMetric
    return isinstance(spec, kinds) or spec.kind == "span"


def unit_doubts(
    spec: MetricSpec, unit: Callable[[str], Unit], parameter: Parameters
) -> tuple[str, ...]:
    """Return what is a guess where a metric's signals come into its own unit.

    ``unit`` returns that of a recorded signal.

    Raises:
        ScenarioError, fmus.units.UnitError: a factor is missing or zero, or the
            dimensions differ.
    """
    if isinstance(spec, SineMetric) and spec.against:
        return ()
    own = unit_of(factors(spec, unit(spec.of), parameter).unit)
    doubts = conversion(own, spec.unit).doubts if spec.unit else ()
    if isinstance(spec, ErrorMetric | ContourMetric):
        other = spec.against if isinstance(spec, ErrorMetric) else spec.across
        beside = factors(spec, unit(other), parameter).unit
        doubts += conversion(beside, spec.unit or own).doubts
    return doubts


def factors(spec: MetricSpec, unit: str, parameter: Parameters) -> Quantity:
    """Return scale / per, in the unit that a signal in ``unit`` takes by it."""
    scale, per = (factor(f, parameter) for f in (spec.scale, spec.per))
    if per.value == 0:
        raise ScenarioError(f"per: {spec.per} is zero")
    unit = quotient_unit(product_unit(unit, scale.unit), per.unit)
    return Quantity(scale.value / per.value, unit)


def factor(written: Factor, parameter: Parameters) -> Quantity:
    """Return a factor given as number, number with unit or ``component.parameter``."""
    if isinstance(written, Quantity):
        return written
    if not isinstance(written, str):
        return Quantity(written)
    if written[:1].isalpha() or written.startswith("_"):
        return parameter(written)
    try:
        return parse_quantity(written)
    except ValueError as error:
        raise ScenarioError(str(error)) from None


def _figures(
    spec: MetricSpec, signals: Mapping[str, Signal], parameter: Parameters
) -> dict[str, Quantity]:
    found = taken(spec, signals)
    of = found["of"]
    rows = _rows(spec, of)
    time = of.time[rows]
    own = None if isinstance(spec, SineMetric) and spec.against else spec.unit
    values, unit = scaled(spec, of, parameter, own)
    y = values[rows]
    if isinstance(spec, ErrorMetric):
        reference, _ = scaled(spec, found["against"], parameter, unit)
        return _of_error(reference[rows] - y, unit)
    if isinstance(spec, PluginMetric):
        return of_plugin(spec, time, y, unit)
    if isinstance(spec, PlainMetric):
        figure_unit = unit.of_difference() if spec.kind == "span" else unit
        return {spec.kind: Quantity(_PLAIN[spec.kind](y), figure_unit)}
    if isinstance(spec, SettlingMetric):
        start = float(spec.window[0]) if spec.window else 0.0
        away = y - spec.final
        return settling(time - start, away, spec.band, unit.of_difference())
    if isinstance(spec, StepMetric):
        start = float(spec.window[0]) if spec.window else 0.0
        height = in_unit(factor(spec.height, parameter), unit)
        of_error = unit.of_difference()
        return step_response(time - start, y, height, spec.band, of_error)
    if isinstance(spec, ContourMetric):
        across, _ = scaled(spec, found["across"], parameter, unit)
        size = in_unit(factor(spec.size, parameter), unit)
        outside = contour_error(y, across[rows], spec.shape, size)
        kinds = ("peak", "rms", "max", "min")
        off = unit.of_difference()
        return {kind: Quantity(_PLAIN[kind](outside), off) for kind in kinds}
    if isinstance(spec, SustainedMetric):
        start = float(spec.window[0]) if spec.window else 0.0
        level = found["level"]
        times = float(spec.dwell), float(spec.tail)
        first = sustained(time - start, y, level.values[rows], *times, spec.span)
        if first is not None:
            return {"level": Quantity(first, level.unit)}
        highest = Quantity(float(level.values[rows][-1]), level.unit)
        why = f"no oscillation of more than {Quantity(spec.span, unit)} up to {highest}"
        return {"level": NoValue(level.unit, why=why)}
    if isinstance(spec, OnsetMetric):
        ramp = found["ramp"]
        return onset(time, y, ramp.values[rows], spec.piece, ramp.unit)
    unit = unit.of_difference()
    if isinstance(spec, SpectrumMetric) and spec.band_hz is not None:
        return strongest_line(time, y, spec.band_hz, unit)
    assert spec.frequency_hz is not None  # the schema lets none of them be without
    frequency = factor(spec.frequency_hz, parameter)
    hertz = frequency.to("Hz").value if frequency.unit != "1" else frequency.value
    if isinstance(spec, SpectrumMetric):
        return spectrum_line(time, y, hertz, unit)
    assert isinstance(spec, SineMetric)
    if "against" not in found:
        return Sine(time, y, hertz, unit).figures()
    against = found["against"]
    base = Sine(time, against.values[rows], hertz, unit_of(against.unit))
    return Sine(time, y, hertz, unit).over(base, spec.unit, against.name)


_PLAIN: dict[str, Callable[[Array], float]] = {
    "peak": lambda y: float(np.max(np.abs(y))),
    "rms": lambda y: float(np.sqrt(np.mean(y**2))),
    "mean": lambda y: float(np.mean(y)),
    "mean_abs": lambda y: float(np.mean(np.abs(y))),
    "max": lambda y: float(np.max(y)),
    "min": lambda y: float(np.min(y)),
    "final": lambda y: float(y[-1]),
    "span": lambda y: float(np.ptp(y)),
}


def in_unit(quantity: Quantity, unit: str) -> float:
    """Return the value of a quantity in a unit; a plain number is in it already."""
    return quantity.value if quantity.unit == "1" else quantity.to(unit).value


def _of_error(e: Array, unit: Unit) -> dict[str, Quantity]:
    kinds = ("peak", "rms", "mean")
    return {kind: Quantity(_PLAIN[kind](e), unit.of_difference()) for kind in kinds}


def settling(time: Array, y: Array, band: float, unit: str) -> dict[str, Quantity]:
    """Return peak, its time, and the first time after which |y| <= band * peak.

    ``time`` (n,) in s and ``y`` (n,), zero when settled.  If the last row is outside
    the band, that time has no value.
    """
    size = np.abs(y)
    top = int(np.argmax(size))
    outside = np.flatnonzero(size > band * size[top])
    first = int(outside[-1]) + 1 if len(outside) else 0
    settled = Quantity(float(time[first]), "s") if first < len(y) else None
    return {
        "settling": settled
        or NoValue(
            "s",
            why=f"not settled: {Quantity(float(y[-1]), unit)} at {time[-1]:g} s is "
            f"beyond {100 * band:g} % of the peak",
        ),
        "peak": Quantity(float(size[top]), unit),
        "peak_time": Quantity(float(time[top]), "s"),
    }


def _rows(spec: MetricSpec, signal: Signal) -> slice:
    if spec.window is None:
        return slice(None)
    start, end = (float(t) for t in spec.window)
    slack = 1e-12 * max(1.0, abs(end))
    first = int(np.searchsorted(signal.time, start - slack))
    last = int(np.searchsorted(signal.time, end + slack, side="right"))
    if last - first < 1:
        raise ScenarioError(f"no row of {signal.name} lies in [{start:g}, {end:g}] s")
    return slice(first, last)
