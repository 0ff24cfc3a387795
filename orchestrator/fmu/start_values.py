"""Parameters and start values of a component, as what is written to its FMU."""

from collections.abc import Mapping, Sequence
from math import isfinite

from orchestrator.errors import WiringError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, ports
from orchestrator.system import Component, Value

Written = tuple[FmuVariable, tuple[float, ...]]


def start_values(component: Component, fmu: FmuDescription) -> tuple[Written, ...]:
    """Return what is written before initialisation, as the FMU's own numbers.

    Raises:
        WiringError: no such variable, one that cannot be set, not as many numbers
            as it has, true or false for a number, or one that is not finite or
            out of its bounds.
    """
    written: list[Written] = []
    for section in ("parameters", "start"):
        values: Mapping[str, Value] = getattr(component, section)
        for name, value in values.items():
            where = f"components.{component.name}.{section}.{name}"
            try:
                found = ports(component, fmu, name)
            except WiringError as error:
                raise WiringError(f"{where}: {error}") from None
            written.extend(_numbers(where, found, value))
    return tuple(written)


def _numbers(where: str, found: Sequence[Port], value: Value) -> list[Written]:
    for port in found:
        v = port.variable
        settable = v.causality in ("parameter", "input", "structuralParameter")
        settable = settable or v.initial in ("exact", "approx")
        if not settable or v.variability == "constant":
            raise WiringError(
                f"{where}: a {v.variability} {v.causality} of the FMU cannot be set"
            )
    given = value if isinstance(value, tuple) else (value,)
    numbers = [float(v) for v in given]
    if len(numbers) != len(found):
        raise WiringError(
            f"{where}: {len(found)} numbers expected, {len(numbers)} given"
        )
    for port, one in zip(found, given, strict=True):
        if isinstance(one, bool) and port.variable.sort == "real":
            raise WiringError(
                f"{where} = {str(one).lower()}: {port.full_name} is no switch; give a "
                f"number in {port.unit or '1'}"
            )
    if not all(map(isfinite, numbers)):
        raise WiringError(f"{where} = {value}: must be a finite number")
    whole: dict[str, tuple[FmuVariable, list[float]]] = {}
    for port, number in zip(found, numbers, strict=True):
        v = port.variable
        whole.setdefault(v.name, (v, _declared(v)))
        whole[v.name][1][port.element] = _bounded(where, port, number)
    return [(variable, tuple(values)) for variable, values in whole.values()]


def _bounded(where: str, port: Port, number: float) -> float:
    """Return a number as the FMU's own, which must lie within its bounds."""
    affine = port.to_theirs
    theirs = affine.gain * number + affine.offset
    low, high = (
        float(b) if b else None for b in (port.variable.min, port.variable.max)
    )
    for bound, broken, word in (
        (low, low is not None and theirs < low, "least"),
        (high, high is not None and theirs > high, "most"),
    ):
        if broken:
            raise WiringError(
                f"{where} = {number:g}: the FMU allows at {word} {bound:g} "
                f"{port.variable.unit or ''}".rstrip()
            )
    return theirs


def _declared(variable: FmuVariable) -> list[float]:
    """Return a variable's start values as the FMU declares them, else zeros."""
    words = {"true": 1.0, "false": 0.0}
    declared = [
        words[w] if w in words else float(w) for w in (variable.start or "").split()
    ]
    if len(declared) == 1:
        return declared * variable.size
    return declared if len(declared) == variable.size else [0.0] * variable.size
