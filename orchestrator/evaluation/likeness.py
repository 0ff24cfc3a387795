"""Whole signals against those of an earlier run, kept as a baseline.

tube       every row lies between the least and the largest value that the baseline
           has within the time tolerance, widened by absolute + relative * range
events     a signal that changes in few rows (a switch, a mode) changes as often,
           each time within the time tolerance: a tube alone lets pulses vanish
frequency  where one spectral line carries most of the signal it keeps its place:
           a tube wider than a period takes any oscillation of that size
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchestrator.evaluation.schema import Likeness, Tolerance
from orchestrator.evaluation.spectrum import strongest_line
from orchestrator.quantities.quantity import NoValue, Quantity, converter
from orchestrator.result import Signal

Array = NDArray[np.float64]

FEW = 0.1  # of the rows, in which a signal with events changes at most
DOMINANT = 0.5  # of the mean square about a straight line, in one spectral line
NEAR = 0.5  # of the spacing of spectral lines, within which two are the same
STEPS = 5  # of Gauss and Newton for the shift
EXPLAINS = 0.1  # of the deviation is left once a shift or a factor is taken out


@dataclass(frozen=True)
class Difference:
    """What of a signal is not as in the baseline, in words."""

    signal: str
    text: str

    def __str__(self) -> str:
        return f"{self.signal}: {self.text}"


def differences(
    baseline: Mapping[str, Signal], signals: Mapping[str, Signal], spec: Likeness
) -> Iterator[Difference]:
    """Yield how a run differs from its baseline beyond the tolerances.

    Raises:
        fmus.units.UnitError: a signal has a unit of another quantity by now.
    """
    for name in spec.signals or baseline:
        if name not in baseline:
            yield Difference(name, "is not in the baseline; update it")
        elif name not in signals:
            yield Difference(name, "is in the baseline, but was not recorded")
        else:
            tolerance = spec.of(name)
            for text in _compared(baseline[name], signals[name], tolerance):
                yield Difference(name, text)


def _compared(was: Signal, now: Signal, tolerance: Tolerance) -> Iterator[str]:
    if not np.array_equal(was.time, now.time):
        yield (
            f"has {len(now)} rows up to {now.time[-1]:.9g} s, the baseline {len(was)} "
            f"up to {was.time[-1]:.9g} s: stop or rate is another; update the baseline"
        )
        return
    time, r = was.time, was.values.astype(float)
    if not np.isfinite(r).all():
        yield "the baseline holds values that are no finite numbers; update it"
        return
    y = np.asarray(converter(now.unit, was.unit)(now.values.astype(float)))
    width = tolerance.absolute + tolerance.relative * float(np.ptp(r))
    lower, upper = tube(time, r, float(tolerance.time))
    beyond = np.maximum(np.maximum(y - upper, lower - y) - width, 0.0)
    beyond[~np.isfinite(y)] = np.inf
    if np.any(beyond > 0):
        yield _worst(time, r, y, beyond, width, tolerance, was.unit)
    if text := _events(time, r, y, width, float(tolerance.time)):
        yield text
    if text := _frequency(time, r, y, tolerance.frequency):
        yield text


def tube(time: Array, values: Array, reach: float) -> tuple[Array, Array]:
    """Return the least and largest value within ``reach`` (s) of every row.

    Between rows, which are equally spaced, the signal is taken as a straight line.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    if len(time) < 2 or reach <= 0:
        return values, values
    period = (time[-1] - time[0]) / (len(time) - 1)
    rows = int(reach / period * (1 + 1e-9))
    size = 2 * min(rows, len(time)) + 1
    lower = minimum_filter1d(values, size, mode="nearest")
    upper = maximum_filter1d(values, size, mode="nearest")
    for ends in (time - reach, time + reach):
        edge = np.interp(ends, time, values)
        lower, upper = np.minimum(lower, edge), np.maximum(upper, edge)
    return lower, upper


def _worst(
    time: Array,
    r: Array,
    y: Array,
    beyond: Array,
    width: float,
    tolerance: Tolerance,
    unit: str,
) -> str:
    worst = int(np.argmax(beyond))
    outside = beyond > 0
    before, after = np.flatnonzero(~outside[:worst]), np.flatnonzero(~outside[worst:])
    first = int(before[-1]) + 1 if len(before) else 0
    last = worst + int(after[0]) - 1 if len(after) else len(y) - 1
    here, there = Quantity(float(y[worst]), unit), Quantity(float(r[worst]), unit)
    widths = f"+-{Quantity(width, unit)}, +-{float(tolerance.time):g} s"
    stretch = f"from {time[first]:.6g} s to {time[last]:.6g} s, at {time[worst]:.6g} s"
    return (
        f"leaves the tube of the baseline ({widths}) in {np.count_nonzero(outside)} of "
        f"{len(y)} rows; worst {stretch}: {here}, baseline {there}"
        f"{_explained(time, r, y)}"
    )


def _explained(time: Array, r: Array, y: Array) -> str:
    """Return which shift or factor the deviation amounts to, if to one of them."""
    size = float(np.sum((y - r) ** 2))
    if not np.isfinite(size) or len(time) < 3 or not np.ptp(r):
        return ""
    factor = float(np.sum(r * y) / np.sum(r**2))
    shift = 0.0
    for _ in range(STEPS):
        there = np.interp(time - shift, time, r)
        slope = -np.gradient(there, time)
        power = float(np.sum(slope**2))
        shift += float(np.sum(slope * (y - there))) / power if power else 0.0
    left = {
        f"a factor of {factor:.4g}": factor * r,
        f"a shift of {shift:+.3g} s": np.interp(time - shift, time, r),
    }
    rest, words = min((float(np.sum((y - v) ** 2)), text) for text, v in left.items())
    return f"; it amounts to {words}" if rest < EXPLAINS * size else ""


def _events(time: Array, r: Array, y: Array, width: float, reach: float) -> str | None:
    was, now = (time[1:][np.abs(np.diff(v)) > width] for v in (r, y))
    if not 0 < len(was) <= FEW * len(time):
        return None
    if len(was) != len(now):
        return f"changes {len(now)} times, in the baseline {len(was)} times"
    apart = np.abs(now - was)
    late = int(np.argmax(apart))
    if apart[late] <= reach * (1 + 1e-9):
        return None
    return (
        f"changes at {now[late]:.6g} s, in the baseline at {was[late]:.6g} s "
        f"(+-{reach:g} s)"
    )


def _frequency(time: Array, r: Array, y: Array, tolerance: float) -> str | None:
    was, now = _dominant(time, r), _dominant(time, y)
    if was is None:
        return None
    if now is None:
        return f"has no dominant frequency, the baseline {was:.6g} Hz"
    spacing = 1 / (time[-1] - time[0])
    if abs(now - was) <= max(tolerance * was, NEAR * spacing):
        return None
    return f"oscillates at {now:.6g} Hz, the baseline at {was:.6g} Hz"


def _dominant(time: Array, values: Array) -> float | None:
    """Return the frequency (Hz) that carries most of a signal; None without one."""
    if len(time) < 16 or not np.isfinite(values).all():
        return None
    straight = np.polynomial.Polynomial.fit(time, values, 1)
    rest = values - straight(time)
    power = float(np.mean(rest**2))
    if power <= 1e-24 * float(np.mean(values**2)) or power == 0:
        return None
    span = time[-1] - time[0]
    band = 3 / span, len(time) / span / 2
    line = strongest_line(time, rest, band, "1")
    if isinstance(line["amplitude"], NoValue):
        return None
    carried = line["amplitude"].value ** 2 / 2
    return line["frequency"].value if carried > DOMINANT * power else None
