"""The unit of a signal: its name and the definition that holds where it is written.

A ``Unit`` is its name as text, so it prints, compares and is stored as such; beside
it stand the base units of the FMU that named it.  Plain text is read by our own
table.  Everything that converts does it by ``conversion``: connections, maps,
metrics, expectations, comparisons and reports cannot disagree.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import isclose
from typing import Any, NamedTuple

from fmus import units
from fmus.units import BaseUnit, TurnError, UnitError, base_unit

SAME_FACTOR = 1e-9
_UNDEFINED = "names the unit"


class Unit(str):
    """A unit's name with its definition; ``base`` is None where nobody gives one.

    ``relative`` units are of differences, to which an offset never applies.
    ``doubt`` says what of the definition is a guess of ours.
    """

    base: BaseUnit | None
    relative: bool
    doubt: str

    def __new__(
        cls,
        name: str,
        base: BaseUnit | None = None,
        *,
        relative: bool = False,
        doubt: str = "",
    ) -> "Unit":
        unit = super().__new__(cls, name)
        unit.base, unit.relative, unit.doubt = base, relative, doubt
        return unit

    @property
    def is_defined(self) -> bool:
        """Whether somebody has said what it is; our table only supposes."""
        return self.base is not None and not self.doubt.startswith(_UNDEFINED)

    def of_difference(self, relative: bool = True) -> "Unit":
        """Return the same unit for a difference of two values."""
        return Unit(self, self.base, relative=relative, doubt=self.doubt)

    def metadata(self) -> dict[str, str]:
        """Return what a result file says of a column: name and definition."""
        defined = {} if self.base is None else self.base.exponents
        kept: dict[str, Any] = dict(defined)
        if self.base is not None:
            kept |= {"factor": self.base.factor, "offset": self.base.offset}
        kept |= {"relative": self.relative} if self.relative else {}
        return {"unit": str(self), "definition": json.dumps(kept)}

    @classmethod
    def from_metadata(cls, metadata: Mapping[bytes, bytes]) -> "Unit":
        """Return the unit of a column of a result file."""
        name = metadata[b"unit"].decode()
        if b"definition" not in metadata:  # written before definitions were kept
            return unit_of(name)
        kept = json.loads(metadata[b"definition"])
        relative = kept.pop("relative", False)
        doubt = "" if kept else f"{_UNDEFINED} {name} without defining it"
        base = BaseUnit(**kept) if kept else None
        return cls(name, base, relative=relative, doubt=doubt)


class UndefinedUnit(UnitError):
    """An FMU names a unit that neither it defines nor our table knows."""


class Conversion(NamedTuple):
    """sink value = gain * source value + offset; ``doubts`` say what is a guess."""

    gain: float = 1.0
    offset: float = 0.0
    doubts: tuple[str, ...] = ()


def unit_of(text: str) -> Unit:
    """Return a unit as it is, plain text by our own table.

    Raises:
        UnitError: it is no unit.
    """
    return text if isinstance(text, Unit) else Unit(text, base_unit(text))


def unit_of_fmu(
    name: str, definition: BaseUnit | None, *, relative: bool = False
) -> Unit:
    """Return the unit an FMU names, with what it defines it to be.

    What it leaves out, the whole definition or the radian in it, is filled in from
    our own table where the rest agrees; ``doubt`` says so.
    """
    try:
        usual = base_unit(name)
    except UnitError:
        usual = None
    if definition is None:
        doubt = f"{_UNDEFINED} {name} without defining it"
        doubt = "" if usual == BaseUnit() else doubt  # "-" and the like: no unit
        return Unit(name, usual, relative=relative, doubt=doubt)
    if usual and usual.rad and definition.rad == 0 and _alike(definition, usual):
        doubt = f"defines the unit {name} without the radian"
        definition = replace(definition, rad=usual.rad)
        return Unit(name, definition, relative=relative, doubt=doubt)
    return Unit(name, definition, relative=relative)


def _alike(one: BaseUnit, other: BaseUnit) -> bool:
    return (
        replace(one, rad=0).exponents == replace(other, rad=0).exponents
        and isclose(one.factor, other.factor, rel_tol=SAME_FACTOR)
        and one.offset == other.offset
    )


def conversion(source: str, sink: str) -> Conversion:
    """Return how a number in ``source`` becomes one in ``sink``.

    Raises:
        UndefinedUnit: one of them has no definition, and they differ.
        fmus.units.TurnError: frequencies of which one counts radians.
        UnitError: they measure different quantities.
    """
    given, wanted = unit_of(source), unit_of(sink)
    if str(given) == str(wanted):
        if given.base == wanted.base:
            return Conversion()
        if bare := next((u for u in (given, wanted) if not u.is_defined), None):
            return Conversion(doubts=(f"the FMU {bare.doubt}; taken as the other's",))
    if given.base is None or wanted.base is None:
        unit = given if given.base is None else wanted
        raise UndefinedUnit(f"{given} cannot become {wanted}: the FMU {unit.doubt}")
    relative = given.relative or wanted.relative
    try:
        found = units.conversion(given.base, wanted.base, relative=relative)
    except TurnError:
        raise TurnError(
            f"{spelled(given)} cannot become {spelled(wanted)}: one counts radians, "
            f"the other does not, and a turn may be 1 or 2 pi of it"
        ) from None
    except UnitError:
        raise UnitError(
            f"{told(given)} cannot become {told(wanted)}; they measure different "
            f"quantities"
        ) from None
    doubts = [
        f"the FMU {unit.doubt}; taken as {_spelled_out(unit.base)}"
        for unit in (given, wanted)
        if unit.doubt and unit.base
    ]
    if found.ignored_rad:
        doubts.append(
            f"{spelled(given)} becomes {spelled(wanted)} with the radian counted as 1"
        )
    differ = given.relative != wanted.relative
    if differ and given.base.offset != wanted.base.offset:
        one, other = ("difference", "value")[:: 1 if given.relative else -1]
        doubts.append(f"a {one} in {given} becomes a {other} in {wanted}")
    return Conversion(found.gain, found.offset, tuple(doubts))


def told(unit: Unit) -> str:
    """Return a unit for messages, with its base units where its name misleads."""
    if unit == "1":
        return "a pure number"
    try:
        usual = base_unit(unit)
    except UnitError:
        usual = None
    return str(unit) if unit.base in (usual, None) else spelled(unit)


def spelled(unit: Unit) -> str:
    """Return a unit with its base units."""
    return f"{unit} ({_spelled_out(unit.base)})" if unit.base else str(unit)


def _spelled_out(base: BaseUnit) -> str:
    factor = "" if base.factor == 1 else f"{base.factor:.9g} "
    return factor + base.dimension


def product_unit(*factors: str) -> Unit:
    """Return the unit of a product of quantities, as models write units.

    Raises:
        UnitError: a value with an offset, a temperature say, is multiplied.
    """
    kept = [unit_of(unit) for unit in factors if unit != "1"]
    if not kept:
        return unit_of("1")
    if len(kept) == 1:
        return kept[0]
    return _combined(".".join(kept), [(unit, 1) for unit in kept])


def quotient_unit(above: str, below: str) -> Unit:
    """Return the unit of a quotient of two quantities, as models write units.

    Raises:
        UnitError: a value with an offset, a temperature say, is divided.
    """
    top, bottom = unit_of(above), unit_of(below)
    if bottom == "1":
        return top
    if top == bottom and top.base == bottom.base:
        refuse_multiple(f"{top}/{bottom}", top)
        return unit_of("1")
    name = f"{top}/({bottom})" if set("./*·- ") & set(bottom) else f"{top}/{bottom}"
    return _combined(name, [(top, 1), (bottom, -1)])


def refuse_multiple(name: str, unit: Unit) -> None:
    """Refuse that a value is multiplied or divided whose zero is no zero.

    Raises:
        UnitError: the unit has an offset, and is of no difference.
    """
    if unit.base is not None and unit.base.offset and not unit.relative:
        raise UnitError(
            f"{name}: a value in {unit} is no multiple of a unit; give the variable a "
            f"map with a unit that begins at zero (K), or take a difference of two"
        )


def _combined(name: str, powers: list[tuple[Unit, int]]) -> Unit:
    exponents: dict[str, int] = {}
    factor = Fraction(1)
    for unit, power in powers:
        if unit.base is None:
            raise UndefinedUnit(f"{name}: the FMU {unit.doubt}")
        refuse_multiple(name, unit)
        factor *= Fraction(repr(unit.base.factor)) ** power
        for base, exponent in unit.base.exponents.items():
            exponents[base] = exponents.get(base, 0) + power * exponent
    doubt = next((unit.doubt for unit, _ in powers if unit.doubt), "")
    relative = any(unit.relative for unit, _ in powers)
    whole = BaseUnit(**exponents, factor=float(factor))
    return Unit(name, whole, relative=relative, doubt=doubt)


class UnitNames:
    """What unit names mean in a scenario: to the FMU at hand, to another FMU of the
    system, to our own table, in this order."""

    def __init__(self, defined: Mapping[str, Mapping[str, BaseUnit]]) -> None:
        self._defined = defined

    def unit(self, text: str, component: str, like: Unit | None = None) -> Unit:
        """Return the unit that a name means beside a component's variable.

        ``like`` is the unit of that variable, which may be one without definition.

        Raises:
            UnitError: it is no unit, or others define it in different ways.
        """
        if like is not None and text == like:
            return like
        relative = like is not None and like.relative
        return Unit(text, base_unit(text, self._names(component)), relative=relative)

    def _names(self, component: str) -> Mapping[str, BaseUnit]:
        found = _Names()
        for owner, names in self._defined.items():
            if owner != component:
                for name, base in names.items():
                    found.of_others.setdefault(name, {})[owner] = base
        found.update(self._defined.get(component, {}))
        return found


class _Names(dict[str, BaseUnit]):
    """One FMU's unit names before those of others, which must agree when asked."""

    def __init__(self) -> None:
        super().__init__()
        self.of_others: dict[str, dict[str, BaseUnit]] = {}

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or name in self.of_others

    def __missing__(self, name: str) -> BaseUnit:
        definitions = self.of_others[name]
        first, *rest = definitions.values()
        if any(other != first for other in rest):
            owners = " and ".join(definitions)
            raise UnitError(f"{name} is defined in different ways by {owners}")
        return first
