"""Exact times and values that carry their unit.

A time or rate is read by its decimal text, never through a binary float:
``"1/20000"``, ``"0.36e-3"``, ``"50 us"``, ``"20 kHz"``, ``2`` and the TOML
number ``0.5`` are exact fractions of a second (a rate stands for its period).
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from math import isfinite
from typing import Any

from orchestrator.quantities.unit import Unit, conversion, unit_of

SECONDS = {
    "s": Fraction(1),
    "ms": Fraction(1, 10**3),
    "us": Fraction(1, 10**6),
    "µs": Fraction(1, 10**6),
    "ns": Fraction(1, 10**9),
    "min": Fraction(60),
    "h": Fraction(3600),
}
_HERTZ = {"Hz": Fraction(1), "kHz": Fraction(10**3), "MHz": Fraction(10**6)}
_BYTES = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9}
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_POWER = re.compile(r"[eE]([+-]?[0-9_]+)")
_TIME = re.compile(rf"\s*({_NUMBER})(?:\s*/\s*({_NUMBER}))?\s*([^\W\d]+)?\s*")


class DecimalFloat(float):
    """A float that remembers the decimal text it was read from."""

    text: str

    def __new__(cls, text: str) -> "DecimalFloat":
        number = super().__new__(cls, text)
        number.text = text
        return number


def exact(text: str) -> Fraction:
    """Return a number exactly as it is written, say by an FMU.

    Raises:
        ValueError: it is none, or has more digits than a double could mean.
    """
    if len(text) > 1000 or not isfinite(float(text) if "/" not in text else 0.0):
        raise ValueError(f"{text[:40]!r} is no finite number")
    if (power := _POWER.search(text)) and abs(int(power[1])) > 400:
        raise ValueError(f"{text[:40]!r} has an exponent beyond 400")
    return Fraction(text)


def parse_time(value: Any) -> Fraction:
    """Return a time (s) exactly; a rate in hertz gives its period.

    Raises:
        ValueError: the value is not a finite time, or a rate of zero.
    """
    if isinstance(value, Fraction):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal | str):
        raise ValueError(f"{value!r} is not a time; {_FORMS}")
    text = value.text if isinstance(value, DecimalFloat) else str(value)
    match = _TIME.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a time; {_FORMS}")
    above, below, unit = match.groups()
    number = Fraction(above)
    if below is not None:
        if Fraction(below) == 0:
            raise ValueError(f"{text!r} divides by zero")
        number /= Fraction(below)
    if unit is None or unit in SECONDS:
        return number * SECONDS[unit or "s"]
    if unit not in _HERTZ:
        raise ValueError(
            f"{text!r}: {unit!r} is no unit of time; write one of "
            f"{', '.join((*SECONDS, *_HERTZ))}"
        )
    if number == 0:
        raise ValueError(f"{text!r}: a rate of zero has no period")
    return 1 / (number * _HERTZ[unit])


_FORMS = 'write "1/20000", "0.36e-3", "50 us" or "20 kHz" (seconds without a unit)'


def parse_period(value: Any) -> Fraction:
    """Return a period (s) exactly.

    Raises:
        ValueError: not a time, or not greater than zero.
    """
    period = parse_time(value)
    if period <= 0:
        raise ValueError(f"{value} is not a time greater than zero")
    return period


def parse_bytes(value: Any) -> float:
    """Return an amount of memory: a number of bytes, or text such as ``"2 GB"``.

    Raises:
        ValueError: not an amount of memory, or not greater than zero.
    """
    match = re.fullmatch(rf"\s*({_NUMBER})\s*(B|kB|MB|GB)?\s*", str(value))
    size = float(match[1]) * _BYTES[match[2] or "B"] if match else 0.0
    if size <= 0:
        raise ValueError(f'{value!r} is no amount of memory; write "500 MB" or "2 GB"')
    return size


def time_text(value: Fraction) -> str:
    """Return the text of a time that ``parse_time`` reads back exactly."""
    return str(value)


def rate(period: Fraction) -> str:
    """Return a period for people: ``50 us (20 kHz)``."""
    hertz = 1 / period
    size, unit = (hertz / 1000, "kHz") if hertz >= 1000 else (hertz, "Hz")
    return f"{float(period * 10**6):g} us ({float(size):g} {unit})"


@dataclass(frozen=True)
class Quantity:
    """A number and its unit (``1`` if it has none)."""

    value: float
    unit: str = "1"

    def to(self, unit: str | None) -> "Quantity":
        """Return the same quantity in another unit (None: as it is).

        Raises:
            fmus.units.UnitError: the units have different dimensions.
        """
        if unit is None or (unit == self.unit and not isinstance(unit, Unit)):
            return self
        wanted = unit_of(unit).of_difference(unit_of(self.unit).relative)
        return Quantity(converter(self.unit, wanted)(self.value), wanted)

    def __str__(self) -> str:
        return f"{self.value:.6g}" + ("" if self.unit == "1" else f" {self.unit}")


@dataclass(frozen=True)
class NoValue(Quantity):
    """A figure that a run does not have, say a settling time of what never settles.

    ``why`` says so in words; ``value`` is nan, so that no bound is ever met.
    """

    value: float = field(default=float("nan"), init=False, compare=False)
    why: str = field(kw_only=True)

    def to(self, unit: str | None) -> "NoValue":
        return replace(self, unit=Quantity(0.0, self.unit).to(unit).unit)

    def __str__(self) -> str:
        return self.why


def parse_quantity(text: str) -> Quantity:
    """Return a number with its unit, written ``"3.18e-3 m/rad"``.

    Raises:
        ValueError: the text does not begin with a number.
    """
    match = re.fullmatch(rf"\s*({_NUMBER})\s*(.*?)\s*", text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit, as in '2.5 mm'")
    return Quantity(float(match[1]), match[2] or "1")


def converter(source: str, sink: str) -> Callable[[Any], Any]:
    """Return the function that converts numbers or arrays between two units.

    Raises:
        fmus.units.UnitError: the units have different dimensions.
    """
    gain, offset, _ = conversion(source, sink)
    return lambda value: gain * value + offset
