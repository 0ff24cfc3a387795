"""Variables of a composition seen from outside: our name, mapping, unit.

A name stands for one number or for several: an FMI 3 array, the FMI 2 elements
``K[1,2]`` of one, or a record ``command`` with its fields ``command.x``.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import pi
from typing import NamedTuple

from fmus.units import TurnError, UnitError, base_unit
from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.whole import Listed, Whole, listed_of, whole_of
from orchestrator.quantities.unit import UndefinedUnit, Unit, conversion
from orchestrator.system import Component, Mapped


@dataclass(frozen=True)
class Affine:
    """sink = gain * source + offset; exact copies have gain 1 and offset 0."""

    gain: float = 1.0
    offset: float = 0.0

    @property
    def converts(self) -> bool:
        """Tell whether it is more than an exact copy."""
        return (self.gain, self.offset) != (1.0, 0.0)

    def then(self, other: "Affine") -> "Affine":
        gain = other.gain * self.gain
        return Affine(gain, other.gain * self.offset + other.offset)

    def inverse(self) -> "Affine":
        return Affine(1.0 / self.gain, -self.offset / self.gain)


@dataclass(frozen=True)
class Port:
    """One number of one FMU variable.

    ``label`` is what distinguishes it under the name it was asked by (``""``,
    ``[2]``, ``.x``).  Ours and theirs are related by gain and offset in the
    direction of the signal; ``unit`` is that of our side, None if there is none.
    ``doubts`` say what of its map is a guess; with ``asked`` a gain or offset is
    written there, by which a switch may become a number.  ``whole`` is what an integer
    input takes of any number.
    """

    component: str
    name: str
    label: str
    variable: FmuVariable
    element: int
    gain: float
    offset: float
    unit: Unit | None
    doubts: tuple[str, ...] = ()
    asked: bool = False
    whole: Whole | Listed | None = None

    @property
    def full_name(self) -> str:
        return f"{self.component}.{self.name}"

    @property
    def inward(self) -> bool:
        """Whether the signal's direction is into the FMU."""
        return is_inward(self.variable)

    @property
    def to_theirs(self) -> Affine:
        """How a number of ours becomes one of the FMU's."""
        affine = Affine(self.gain, self.offset)
        return affine if self.inward else affine.inverse()

    @property
    def to_ours(self) -> Affine:
        """How a number of the FMU's becomes one of ours."""
        affine = Affine(self.gain, self.offset)
        return affine.inverse() if self.inward else affine


def is_inward(variable: FmuVariable) -> bool:
    """Tell whether values are given to a variable rather than taken from it."""
    return variable.causality in ("input", "parameter", "structuralParameter")


def ports(component: Component, fmu: FmuDescription, name: str) -> list[Port]:
    """Return the numbers a name of a component stands for.

    Elements of an array are in the order of their indices, the last one running
    first, however the FMU lists them.

    Raises:
        WiringError: the component has no such variable, or an array no such element.
    """
    if name in component.map:
        mapped = component.map[name]
        found = list(_ports(component, fmu, mapped.name, mapped))
        return [_renamed(port, name + port.label) for port in found]
    return list(_ports(component, fmu, name, Mapped(name)))


def _ports(
    component: Component, fmu: FmuDescription, name: str, mapped: Mapped
) -> Iterator[Port]:
    variables = fmu.variables
    array, indices = _array_element(variables, name)
    if name in variables:
        members = [(variables[name], "")]
    elif array is not None:
        members = [(array, "")]
    else:
        prefixes = (f"{name}.", f"{name}[")
        members = _by_index(
            (v, n[len(name) :]) for n, v in variables.items() if n.startswith(prefixes)
        )
    if not members:
        if name in fmu.clocks:
            raise WiringError(
                f"{component.name}.{name} is a Clock, which has no value; the master "
                f"ticks the clocks of an FMU by itself"
            )
        known = set(variables) | set(component.map)
        raise WiringError(
            f"{component.name} ({fmu.path.name}) has no variable {name!r}; "
            f"{did_you_mean(name, known)}"
        )
    if array is not None and indices not in _indices(array.shape):
        raise WiringError(
            f"{component.name}.{name} is no element of {array.name}, whose elements "
            f"are {_indices(array.shape)[0]} to {_indices(array.shape)[-1]}"
        )
    for variable, label in members:
        affine, unit, doubts = _our_side(component, fmu, variable, mapped)
        for element, index in enumerate(_indices(variable.shape)):
            if array is not None and index != indices:
                continue
            yield Port(
                component.name,
                variable.name + index,
                "" if array is not None else label + index,
                variable,
                element,
                affine.gain,
                affine.offset,
                unit,
                doubts,
                asked=mapped.gain is not None or mapped.offset is not None,
                whole=whole_of(component, variable, mapped, fmu.fmi_major)
                or listed_of(component, variable, mapped, fmu.fmi_major),
            )


def _array_element(
    variables: Mapping[str, FmuVariable], name: str
) -> tuple[FmuVariable | None, str]:
    """Return the FMI 3 array that ``K[1,2]`` is an element of, and ``[1,2]``."""
    owner, bracket, rest = name.rpartition("[")
    array = variables.get(owner) if bracket else None
    if name in variables or array is None or not array.shape:
        return None, ""
    return array, bracket + rest.replace(" ", "")


def _by_index(
    members: Iterable[tuple[FmuVariable, str]],
) -> list[tuple[FmuVariable, str]]:
    """Return elements, which FMI 2 lists in any order, by index; fields as told."""
    listed = list(members)
    found = [(at, one) for one in listed if (at := indices_of(one[1])) is not None]
    if len(found) < len(listed):
        return listed
    return [one for _, one in sorted(found, key=lambda pair: pair[0])]


def indices_of(label: str) -> tuple[int, ...] | None:
    """Return (1, 2) of ``[1,2]`` or ``[1][2]``, None of what is no index alone."""
    if not re.fullmatch(r"(\[\s*\d+\s*(,\s*\d+\s*)*\])+", label, re.ASCII):
        return None
    return tuple(map(int, re.findall(r"\d+", label, re.ASCII)))


def _renamed(port: Port, name: str) -> Port:
    return replace(port, name=name)


def _indices(shape: tuple[int, ...]) -> list[str]:
    if not shape:
        return [""]
    ranges = (range(1, n + 1) for n in shape)
    return [f"[{','.join(map(str, index))}]" for index in product(*ranges)]


def _our_side(
    component: Component, fmu: FmuDescription, variable: FmuVariable, mapped: Mapped
) -> tuple[Affine, Unit | None, tuple[str, ...]]:
    """Return what a map makes of a variable in the direction of its signal, our
    unit, and what of it is a guess.

    Raises:
        WiringError: the unit of the map cannot be had without a gain.
    """
    theirs = variable.unit
    if variable.is_text and (mapped.gain, mapped.offset, mapped.unit) != (None,) * 3:
        raise WiringError(
            f"components.{component.name}.map: {mapped.name} is {variable.kind}, which "
            f"has no gain, offset or unit"
        )
    given = Affine(
        1.0 if mapped.gain is None else mapped.gain,
        0.0 if mapped.offset is None else mapped.offset,
    )
    if mapped.unit is None:
        return given, theirs, ()
    where = f"components.{component.name}.map: {mapped.name}"
    relative = theirs is not None and theirs.relative
    try:
        ours = mapped.unit
        if not isinstance(ours, Unit):
            ours = Unit(ours, base_unit(ours, fmu.units))
        ours = ours.of_difference(relative)
        if mapped.gain is not None:
            return given, ours, ()
        if theirs is None or mapped.offset is not None:
            lacking = "no unit there" if theirs is None else "an offset alone"
            raise UnitError(f"{lacking}: say by a gain what it is in {ours}")
        ends = (ours, theirs) if is_inward(variable) else (theirs, ours)
        gain, offset, doubts = conversion(*ends)
    except TurnError as error:
        raise WiringError(f"{where}: {error}; give it a gain") from None
    except UnitError as error:
        raise WiringError(f"{where}: {error}; or give it a gain") from None
    return Affine(gain, offset), ours, tuple(f"{where}: {doubt}" for doubt in doubts)


class Passage(NamedTuple):
    """How a value passes over a connection: a note on it, and what is a guess."""

    affine: Affine
    note: str | None
    doubts: tuple[str, ...]


def connection(source: Port, sink: Port) -> Passage:
    """Return how a value passes from one FMU's variable into another's.

    Raises:
        WiringError: types or units do not fit.
    """
    ends = f"{source.full_name} -> {sink.full_name}"
    _check_types(source, sink, ends)
    converted, note = Affine(), None
    doubts: tuple[str, ...] = ()
    if source.unit is None or sink.unit is None:
        if source.unit or sink.unit:
            note = (
                f"{ends}: connected as numbers, {source.unit or 'no unit'} to "
                f"{sink.unit or 'no unit'}, since one side has no unit"
            )
    else:
        try:
            gain, offset, doubts = conversion(source.unit, sink.unit)
            converted = Affine(gain, offset)
        except UndefinedUnit as error:
            doubts = (f"connected as numbers, since {error}",)
        except TurnError as error:
            raise WiringError(f"{ends}: {error}. {_turns(source, sink)}") from None
        except UnitError as error:
            raise WiringError(
                f"{ends}: {error}; connect variables of one quantity, or give the "
                f"component a map with gain and unit"
            ) from None
    whole = source.to_ours.then(converted).then(sink.to_theirs)
    told_of = (*source.doubts, *sink.doubts, *(f"{ends}: {d}" for d in doubts))
    return Passage(whole, note, told_of)


def _check_types(source: Port, sink: Port, ends: str) -> None:
    if source.variable.causality == "input":
        raise WiringError(f"{ends}: the source is an input; name an output instead")
    there, here = source.variable, sink.variable
    refused = f"{ends}: {there.kind} cannot drive {here.kind}"
    if there.is_text or here.is_text:
        if there.sort != here.sort:
            raise WiringError(
                f"{refused}: texts pass to texts and bytes to bytes, as they are"
            )
        return
    if isinstance(sink.whole, Listed):
        if there.sort == "real":
            raise WiringError(f"{refused}: a table lists whole numbers")
        return
    if (there.sort == "boolean") != (here.sort == "boolean"):
        if source.asked or sink.asked:
            return
        number = sink if there.sort == "boolean" else source
        raise WiringError(
            f"{refused} unasked. To take a switch as 0 and 1, write\n\n"
            f"[components.{number.component}.map]\n{json.dumps(number.name)} = "
            f"{{ name = {json.dumps(number.variable.name)}, gain = 1 }}"
        )
    if here.declared.items:
        missing = set(there.declared.items) - set(here.declared.items)
        if not there.declared.items or missing:
            names = ", ".join(sorted(item.name for item in missing))
            raise WiringError(
                f"{refused}: "
                + (f"{names} is no item there" if names else "it may be no item there")
            )
    if there.sort == "real" and here.sort != "real" and sink.whole is None:
        raise WiringError(
            f"{refused}: it would be cut; give the input a map with range = "
            f'"saturate" or "wrap", which rounds, or put a component between them'
        )


def _turns(source: Port, sink: Port) -> str:
    """Return the map to paste where of two frequencies one counts radians."""
    there, here = source, sink
    if _rad(source) and not _rad(sink):
        there, here = sink, source
    assert there.unit is not None
    assert there.unit.base is not None
    counted = Unit(there.unit, replace(there.unit.base, rad=_rad(here)))
    radian = conversion(counted, here.unit or "1").gain
    turn = (2 * pi) ** (_rad(here) - _rad(there)) * radian
    if there.inward:
        turn, radian = 1 / turn, 1 / radian
    return (
        f"If {there.full_name} counts turns, write\n\n"
        f"[components.{there.component}.map]\n{json.dumps(there.name)} = "
        f"{{ name = {json.dumps(there.variable.name)}, gain = {turn!r}, "
        f'unit = "{here.unit}" }}\n\nand if it counts radians, gain = {radian!r}'
    )


def _rad(port: Port) -> int:
    return port.unit.base.rad if port.unit and port.unit.base else 0
