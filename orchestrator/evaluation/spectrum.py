"""A recorded signal's spectrum, and lines of it: one asked for, or the strongest."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.quantities.unit import Unit

FEWEST = 3  # rows that determine a sine and a mean

Array: TypeAlias = NDArray[np.float64]


def spectrum_line(
    time: Array, y: Array, hertz: float, unit: Unit | str
) -> dict[str, Quantity]:
    """Return amplitude and frequency of the spectral line nearest ``hertz``.

    One-sided, Hann window, amplitude of the equivalent sine; rows equally spaced.
    """
    if why := unseen(time, hertz):
        none = NoValue(unit, why=why)
        return {"amplitude": none, "frequency": NoValue("Hz", why=why)}
    lines, power = _spectrum(time, y)
    nearest = int(np.argmin(np.abs(lines - hertz)))
    return {
        "amplitude": Quantity(float(np.sqrt(2 * power[nearest])), unit),
        "frequency": Quantity(float(lines[nearest]), "Hz"),
    }


def unseen(time: Array, hertz: float) -> str | None:
    """Return why rows at these times (s) show no sine of ``hertz``, if they do not.

    From half their rate on they would show another frequency's, its alias.
    """
    if not hertz > 0:
        return f"{hertz:g} Hz is no frequency of a sine"
    if len(time) < FEWEST:
        return f"{len(time)} rows are too few for a sine and a mean"
    rate = (len(time) - 1) / (time[-1] - time[0])
    if hertz < rate / 2 * (1 - 1e-9):
        return None
    return (
        f"{hertz:g} Hz is not below half the rate of its rows, {rate:g} Hz; record "
        f"them at more than {2 * hertz:g} Hz"
    )


def amplitudes(time: Array, y: Array) -> tuple[Array, Array]:
    """Return the lines (Hz) and the amplitude of the equivalent sine at each.

    One-sided, Hann window; rows equally spaced.
    """
    lines, power = _spectrum(time, y)
    return lines, np.sqrt(2 * power)


def strongest_line(
    time: Array, y: Array, band: tuple[float, float], unit: Unit | str
) -> dict[str, Quantity]:
    """Return amplitude and frequency of the strongest line of ``band`` (Hz).

    The frequency is the vertex of a parabola through the logarithms of the line and
    its neighbours.  A band in which the spectrum has no top has no line.
    """
    if len(time) < FEWEST:
        why = f"{len(time)} rows are too few for a line"
        return {
            "amplitude": NoValue(unit, why=why),
            "frequency": NoValue("Hz", why=why),
        }
    lines, power = _spectrum(time, y)
    tops = 1 + np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:]))
    tops = tops[(lines[tops] >= band[0]) & (lines[tops] <= band[1])]
    if len(tops) == 0:
        why = f"no line stands out from {band[0]:g} to {band[1]:g} Hz"
        return {
            "amplitude": NoValue(unit, why=why),
            "frequency": NoValue("Hz", why=why),
        }
    k = int(tops[np.argmax(power[tops])])
    before, top, after = np.log(power[k - 1 : k + 2] + np.finfo(float).tiny)
    shift = (before - after) / (2 * (before - 2 * top + after))
    return {
        "amplitude": Quantity(float(np.sqrt(2 * power[k])), unit),
        "frequency": Quantity(float(lines[k] + shift * lines[1]), "Hz"),
    }


def _spectrum(time: Array, y: Array) -> tuple[Array, Array]:
    """Return the lines (Hz) of equally spaced rows, and their power."""
    from scipy.signal import periodogram

    rate = (len(time) - 1) / (time[-1] - time[0])
    lines, power = periodogram(y, rate, window="hann", scaling="spectrum")
    return np.asarray(lines), np.asarray(power)
