"""Structural parameters of FMI 3.0: sizes of arrays, set in configuration mode."""

from dataclasses import replace
from fractions import Fraction

from orchestrator.errors import WiringError
from orchestrator.fmu.declared import MOST_NUMBERS
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.system import Component


def is_structural(variable: FmuVariable) -> bool:
    return variable.causality == "structuralParameter"


def sized(fmu: FmuDescription, component: Component) -> FmuDescription:
    """Return an FMU with arrays of the sizes that a component sets.

    Raises:
        WiringError: a size is no whole number of at least 1.
    """
    sizes = {}
    for name, value in component.values.items():
        theirs = component.map[name].name if name in component.map else name
        variable = fmu.variables.get(theirs)
        if variable is None or not is_structural(variable):
            continue
        if isinstance(value, str | bool | tuple) or value != value // 1 or value < 1:
            raise WiringError(
                f"components.{component.name}.parameters.{name} = {value!r}: the size "
                f"of an array is a whole number of at least 1"
            )
        sizes[str(variable.reference)] = int(Fraction(value))
    if not sizes:
        return fmu
    resized = {name: _resized(v, sizes) for name, v in fmu.variables.items()}
    total = sum(v.size for v in resized.values())
    if total > MOST_NUMBERS:
        raise WiringError(
            f"components.{component.name}: its arrays would be {total} numbers; at "
            f"most {MOST_NUMBERS} are accepted"
        )
    return replace(fmu, variables=resized)


def _resized(variable: FmuVariable, sizes: dict[str, int]) -> FmuVariable:
    written = zip(variable.declared.dimensions, variable.shape, strict=True)
    shape = tuple(sizes.get(d, n) if isinstance(d, str) else n for d, n in written)
    return replace(variable, shape=shape)
