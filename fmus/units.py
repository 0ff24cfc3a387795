"""Units as FMI knows them: exponents of eight base units, factor and offset.

A unit is written ``V.s2/rad``: ``.`` multiplies (also ``*``, ``·``, a space, a
hyphen before a letter), a number after a unit is its exponent (``s-2``, ``s^2``,
``s**2``, ``s²``), ``/`` divides by the next factor only, so that ``a/b.c`` is
``a.c/b``; parentheses group, ``1`` is no unit.  A value v in a unit is
factor * v + offset in its base units (FMI 2.0.5 section 2.2.2; FMI 3.0.2 section
2.4.3).  Conversions are computed in exact fractions and rounded once.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from fmus import unit_names
from fmus.unit_names import BASE, Named

LONGEST, HIGHEST = 200, 99  # characters and exponent of a unit
_FACTOR = re.compile(
    r"(?P<name>[^\W\d_]+|[°%µμΩ]+[^\W\d_]*)"
    r"(?:(?:\*\*|\^)\(?(?P<power>[+-]?\d+)\)?|(?P<exponent>[+-]?\d+))?|(?P<one>1)"
)
_BETWEEN = re.compile(r"\s*(?P<sign>[.·*⋅/])\s*|\s+(?=[\w(°%Ω])|-(?=[^\W\d_])")
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_NO_NAMES: Mapping[str, "BaseUnit"] = {}


class UnitError(ValueError):
    """A unit cannot be read, or two units do not measure the same thing."""


class TurnError(UnitError):
    """Of two frequencies one counts radians: a turn may be 1 or 2 pi of the other."""


@dataclass(frozen=True)
class BaseUnit:
    """Exponents of the SI base units and the radian; value in base units =
    factor * value + offset."""

    kg: int = 0
    m: int = 0
    s: int = 0
    A: int = 0
    K: int = 0
    mol: int = 0
    cd: int = 0
    rad: int = 0
    factor: float = 1.0
    offset: float = 0.0

    @property
    def exponents(self) -> dict[str, int]:
        """The exponents that are not zero, by base unit, in the order of FMI."""
        return {name: n for name in BASE if (n := getattr(self, name))}

    @property
    def dimension(self) -> str:
        """The exponents in words: ``kg.m2.s-2``, ``1`` if there are none."""
        above_first = sorted(self.exponents.items(), key=lambda item: item[1] < 0)
        return ".".join(f"{n}{e if e != 1 else ''}" for n, e in above_first) or "1"


class Conversion(NamedTuple):
    """sink value = gain * source value + offset.

    ``ignored_rad`` tells that the exponents of the radian differ.
    """

    gain: float
    offset: float
    ignored_rad: bool


def base_unit(text: str, names: Mapping[str, BaseUnit] = _NO_NAMES) -> BaseUnit:
    """Return the base units, factor and offset of a unit.

    ``names`` are those somebody has defined; they go before our own table.

    Raises:
        UnitError: the text is not a unit of the grammar, a name is unknown, or an
            offset unit stands in a product.
    """
    if text in names:
        return names[text]
    return _of_table(text) if names is _NO_NAMES else _read(text, names)


@cache
def _of_table(text: str) -> BaseUnit:
    return _read(text, _NO_NAMES)


def _read(text: str, names: Mapping[str, BaseUnit]) -> BaseUnit:
    if len(text) > LONGEST:
        raise UnitError(f"unit {text[:20]!r}...: longer than {LONGEST} characters")
    plain = text.translate(_RAISED).strip()
    whole = unit_names.find(plain)
    unit = whole or _Grammar(plain, names).unit()
    try:
        factor, offset = float(unit.factor), float(unit.offset)
    except OverflowError:
        raise UnitError(f"unit {text!r} has a factor beyond all numbers") from None
    return BaseUnit(**unit.exponents, factor=factor, offset=offset)


def conversion(
    source: BaseUnit, sink: BaseUnit, *, relative: bool = False
) -> Conversion:
    """Return how a value in ``source`` becomes one in ``sink``.

    An offset never applies to a ``relative`` quantity, a difference of two values.

    Raises:
        UnitError: they differ in a dimension other than the radian.
        TurnError: they are frequencies, and one of them counts radians.
    """
    mine = source.exponents | {"rad": 0}
    theirs = sink.exponents | {"rad": 0}
    if mine != theirs:
        raise UnitError(f"{source.dimension} is not {sink.dimension}")
    ignored_rad = source.rad != sink.rad
    if ignored_rad and mine == {"s": -1, "rad": 0}:
        raise TurnError(f"{source.dimension} is not {sink.dimension}: a turn is 2 pi")
    scale = _exact(sink.factor)
    between = Fraction(0) if relative else _exact(source.offset) - _exact(sink.offset)
    try:
        gain, offset = float(_exact(source.factor) / scale), float(between / scale)
    except OverflowError:
        raise UnitError(f"a factor of {source.factor:g} / {sink.factor:g}") from None
    return Conversion(gain, offset, ignored_rad)


def _exact(number: float) -> Fraction:
    """Return the decimal that a float stands for: 1 mm is 1000 um to the last bit."""
    return Fraction(repr(number))


class _Grammar:
    """Reads one unit from left to right."""

    def __init__(self, text: str, names: Mapping[str, BaseUnit]) -> None:
        self.text, self.rest, self.names = text, text, names

    def unit(self) -> Named:
        unit = self._product()
        if self.rest:
            raise UnitError(f"unit {self.text!r} cannot be read from {self.rest!r} on")
        return unit

    def _product(self) -> Named:
        """Read factors up to the end or a closing parenthesis."""
        unit = self._factor()
        while match := _BETWEEN.match(self.rest):
            self.rest = self.rest[match.end() :]
            unit = self._times(unit, self._factor(), -1 if match["sign"] == "/" else 1)
        return unit

    def _factor(self) -> Named:
        if self.rest.startswith("("):
            self.rest = self.rest[1:]
            unit = self._product()
            if not self.rest.startswith(")"):
                raise UnitError(f"unit {self.text!r} lacks a closing parenthesis")
            self.rest = self.rest[1:]
            return unit
        match = _FACTOR.match(self.rest)
        if match is None:
            raise UnitError(f"unit {self.text!r} lacks a factor before {self.rest!r}")
        self.rest = self.rest[match.end() :]
        if match["one"]:
            return Named({})
        exponent = int(match["power"] or match["exponent"] or 1)
        if abs(exponent) > HIGHEST:
            raise UnitError(f"unit {self.text!r} has an exponent beyond {HIGHEST}")
        squared = f"{match['name']}{exponent}"  # kgm2
        if exponent != 1 and (spelled := unit_names.find(squared)):
            return spelled
        unit = self._named(match["name"])
        if exponent == 1:
            return unit
        if unit_names.is_product(match["name"]):
            raise UnitError(f"unit {self.text!r}: write a dot between the factors")
        if unit.offset:
            raise UnitError(f"unit {self.text!r} raises an offset unit to a power")
        powers = {name: e * exponent for name, e in unit.exponents.items()}
        return Named(powers, unit.factor**exponent)

    def _named(self, name: str) -> Named:
        if name in self.names:
            known = self.names[name]
            return Named(known.exponents, _exact(known.factor), _exact(known.offset))
        unit = unit_names.find(name)
        if unit is None:
            of = "" if name == self.text else f" in {self.text!r}"
            raise UnitError(f"unknown unit {name!r}{of}; {unit_names.nearest(name)}")
        return unit

    def _times(self, a: Named, b: Named, sign: int) -> Named:
        if a.offset or b.offset:
            raise UnitError(f"unit {self.text!r} multiplies a unit with an offset")
        names = a.exponents.keys() | b.exponents.keys()
        exponents = {
            n: a.exponents.get(n, 0) + sign * b.exponents.get(n, 0) for n in names
        }
        return Named(exponents, a.factor * b.factor**sign)
