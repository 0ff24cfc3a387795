"""Units as FMI knows them: exponents of eight base units, factor and offset.

A unit is written ``V.s2/rad``: ``.`` multiplies, digits after a unit are its
exponent (a sign may precede them), ``/`` divides by the next factor only, so
that ``a/b.c`` is ``a.c/b``; parentheses group, ``1`` is no unit.  Names and
prefixes are those of pint.  A value v in a unit is factor * v + offset in its
base units (FMI 2.0.5 section 2.2.2; FMI 3.0.2 section 2.4.3).
"""

import re
from dataclasses import astuple, dataclass, fields
from decimal import Decimal
from functools import cache
from typing import Any, NamedTuple

from fmus import unit_cache

FACTOR = re.compile(r"(?P<name>[A-Za-zµμΩ°%_]+)(?P<exponent>[+-]?\d+)?|(?P<one>1)")
BASE = {
    "gram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}


class UnitError(ValueError):
    """A unit cannot be read, or two units do not measure the same thing."""


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
        numbers = zip(fields(self), astuple(self), strict=True)
        named = {field.name: number for field, number in numbers}
        return {name: named[name] for name in BASE.values() if named[name]}


class Conversion(NamedTuple):
    """sink value = gain * source value + offset.

    ``ignored_rad`` tells that the exponents of the radian differ.
    """

    gain: float
    offset: float
    ignored_rad: bool


class _Unit(NamedTuple):
    """Exponents by base unit, exact factor and offset."""

    exponents: dict[str, int]
    factor: Decimal
    offset: Decimal


@cache
def base_unit(text: str) -> BaseUnit:
    """Return the base units, factor and offset of a unit.

    Raises:
        UnitError: the text is not a unit of the grammar, a name is unknown, the
            scale is not linear, or an offset unit stands in a product.
    """
    unit, rest = _product(text, text)
    if rest:
        raise UnitError(f"unit {text!r} cannot be read from {rest!r} on")
    return BaseUnit(
        **unit.exponents, factor=float(unit.factor), offset=float(unit.offset)
    )


def conversion(source: BaseUnit, sink: BaseUnit) -> Conversion:
    """Return how a value in ``source`` becomes one in ``sink``.

    Raises:
        UnitError: they differ in a dimension other than the radian.
    """
    mine = source.exponents | {"rad": 0}
    theirs = sink.exponents | {"rad": 0}
    if mine != theirs:
        raise UnitError(f"{_written(source)} is not {_written(sink)}")
    scale = Decimal(repr(sink.factor))  # decimals: 1 mm is 1000 um to the last bit
    gain = Decimal(repr(source.factor)) / scale
    offset = (Decimal(repr(source.offset)) - Decimal(repr(sink.offset))) / scale
    return Conversion(float(gain), float(offset), source.rad != sink.rad)


def _written(unit: BaseUnit) -> str:
    return ".".join(f"{n}{e}" for n, e in unit.exponents.items()) or "1"


def _product(text: str, whole: str) -> tuple[_Unit, str]:
    """Read factors up to the end or a closing parenthesis."""
    unit, rest = _factor(text, whole)
    while rest[:1] in (".", "/", "·"):
        sign = -1 if rest[0] == "/" else 1
        other, rest = _factor(rest[1:], whole)
        unit = _times(unit, other, sign, whole)
    return unit, rest


def _factor(text: str, whole: str) -> tuple[_Unit, str]:
    if text.startswith("("):
        unit, rest = _product(text[1:], whole)
        if not rest.startswith(")"):
            raise UnitError(f"unit {whole!r} lacks a closing parenthesis")
        return unit, rest[1:]
    match = FACTOR.match(text)
    if match is None:
        raise UnitError(f"unit {whole!r} lacks a factor before {text!r}")
    rest = text[match.end() :]
    if match["one"]:
        return _Unit({}, Decimal(1), Decimal(0)), rest
    unit = _named(match["name"])
    exponent = int(match["exponent"] or 1)
    if exponent == 1:
        return unit, rest
    if unit.offset:
        raise UnitError(f"unit {whole!r} raises a unit with an offset to a power")
    powers = {name: e * exponent for name, e in unit.exponents.items()}
    return _Unit(powers, unit.factor**exponent, Decimal(0)), rest


def _times(a: _Unit, b: _Unit, sign: int, whole: str) -> _Unit:
    if a.offset or b.offset:
        raise UnitError(f"unit {whole!r} multiplies a unit with an offset")
    names = a.exponents.keys() | b.exponents.keys()
    exponents = {n: a.exponents.get(n, 0) + sign * b.exponents.get(n, 0) for n in names}
    return _Unit(exponents, a.factor * b.factor**sign, Decimal(0))


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry(non_int_type=Decimal)


@cache
def _named(name: str) -> _Unit:
    """Return a named unit, from the cache where pint was asked before."""
    known = unit_cache.read()
    if name in known:
        exponents, factor, offset = known[name]
        return _Unit(exponents, Decimal(factor), Decimal(offset))
    unit = _look_up(name)
    unit_cache.add(name, (dict(unit.exponents), str(unit.factor), str(unit.offset)))
    return unit


def _look_up(name: str) -> _Unit:
    try:
        registry = _registry()
        zero, one, two = (
            registry.Quantity(Decimal(n), name).to_root_units() for n in range(3)
        )
    except Exception as error:
        raise UnitError(f"unknown unit {name!r}: {error}") from error
    roots = {str(n): int(e) for n, e in one.unit_items() if e == int(e)}
    offset = Decimal(zero.magnitude)
    factor = Decimal(one.magnitude) - offset
    if two.magnitude != 2 * factor + offset or len(roots) != len(one.unit_items()):
        raise UnitError(f"unit {name!r} is not a linear scale of base units")
    if not roots.keys() <= BASE.keys():
        raise UnitError(f"unit {name!r} has no SI base units")
    kilo = Decimal(1000) ** roots.get("gram", 0)
    exponents = {BASE[root]: e for root, e in roots.items()}
    return _Unit(exponents, factor / kilo, offset / kilo)
