"""Variables of a composition seen from outside: our name, mapping, unit.

A name stands for one number or for several: an FMI 3 array, the FMI 2 elements
``K[1,2]`` of one, or a record ``command`` with its fields ``command.x``.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

from fmus.units import BaseUnit, UnitError, base_unit, conversion
from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.system import Component, Mapped


@dataclass(frozen=True)
class Port:
    """One number of one FMU variable.

    ``label`` is what distinguishes it under the name it was asked by (``""``,
    ``[2]``, ``.x``).  Ours and theirs are related by gain and offset in the
    direction of the signal; ``unit`` and ``base`` are those of our side.
    """

    component: str
    name: str
    label: str
    variable: FmuVariable
    element: int
    gain: float
    offset: float
    unit: str | None
    base: BaseUnit | None

    @property
    def full_name(self) -> str:
        return f"{self.component}.{self.name}"


def ports(component: Component, fmu: FmuDescription, name: str) -> list[Port]:
    """Return the numbers a name of a component stands for, in order.

    Raises:
        WiringError: the component has no such variable.
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
        members = [
            (v, n[len(name) :]) for n, v in variables.items() if n.startswith(prefixes)
        ]
    if not members:
        known = set(variables) | set(component.map)
        raise WiringError(
            f"{component.name} ({fmu.path.name}) has no variable {name!r}; "
            f"{did_you_mean(name, known)}"
        )
    for variable, label in members:
        unit, base = _unit(component, variable, mapped)
        for element, index in enumerate(_indices(variable.shape)):
            if array is not None and index != indices:
                continue
            yield Port(
                component.name,
                variable.name + index,
                "" if array is not None else label + index,
                variable,
                element,
                mapped.gain,
                mapped.offset,
                unit,
                base,
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


def _renamed(port: Port, name: str) -> Port:
    return replace(port, name=name)


def _indices(shape: tuple[int, ...]) -> list[str]:
    if not shape:
        return [""]
    ranges = (range(1, n + 1) for n in shape)
    return [f"[{','.join(map(str, index))}]" for index in product(*ranges)]


def _unit(
    component: Component, variable: FmuVariable, mapped: Mapped
) -> tuple[str | None, BaseUnit | None]:
    if mapped.unit is None:
        return variable.unit, variable.base_unit
    try:
        return mapped.unit, base_unit(mapped.unit)
    except UnitError as error:
        raise WiringError(
            f"components.{component.name}.map: unit of {mapped.name}: {error}"
        ) from None


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


def connection(source: Port, sink: Port) -> tuple[Affine, str | None]:
    """Return how a value passes from one FMU's variable into another's, and a note.

    Raises:
        WiringError: types or units do not fit.
    """
    ends = f"{source.full_name} -> {sink.full_name}"
    _check_types(source, sink, ends)
    converted, note = Affine(), None
    if source.base is None or sink.base is None:
        if source.unit or sink.unit:
            note = (
                f"{ends}: connected as numbers, {source.unit or 'no unit'} to "
                f"{sink.unit or 'no unit'}, since one side defines no unit"
            )
    else:
        try:
            gain, offset, rad_ignored = conversion(source.base, sink.base)
        except UnitError:
            raise WiringError(
                f"{ends}: {source.unit} cannot become {sink.unit}; connect variables "
                f"of one quantity, or give the component a map with gain and unit"
            ) from None
        converted = Affine(gain, offset)
        if rad_ignored:
            note = f"{ends}: {source.unit} to {sink.unit}, the rad counted as 1"
    whole = Affine(source.gain, source.offset).then(converted)
    return whole.then(Affine(sink.gain, sink.offset)), note


def _check_types(source: Port, sink: Port, ends: str) -> None:
    if source.variable.causality == "input":
        raise WiringError(f"{ends}: the source is an input; name an output instead")
    kinds = source.variable.sort, sink.variable.sort
    fit = kinds[0] == kinds[1] or kinds == ("integer", "real")
    if not fit or "string" in kinds:
        raise WiringError(
            f"{ends}: a {kinds[0]} variable cannot drive a {kinds[1]} one; put a "
            f"component that converts between them"
        )
