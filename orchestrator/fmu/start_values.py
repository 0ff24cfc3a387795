"""Parameters and start values of a component, as what is written to its FMU.

Parameters and start values are one table: of a name in both the start value holds.
"""

from collections.abc import Sequence
from itertools import product
from typing import TypeAlias

from orchestrator.errors import WiringError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, indices_of, ports
from orchestrator.fmu.shape import refuse_other_shape
from orchestrator.fmu.typed import Held, held
from orchestrator.system import Component

Written: TypeAlias = tuple[FmuVariable, tuple[Held, ...]]


def start_values(component: Component, fmu: FmuDescription) -> tuple[Written, ...]:
    """Return what is written before initialisation, as the FMU's own values.

    Each variable is written once, whole, in the order of the scenario.

    Raises:
        WiringError: no such variable, one that cannot be set, not as many values as
            it has, or one that is none of its type (``typed.py``).
    """
    whole: dict[str, tuple[FmuVariable, list[Held | None]]] = {}
    for name, value in component.values.items():
        section = "start" if name in component.start else "parameters"
        where = f"components.{component.name}.{section}.{name}"
        try:
            found = ports(component, fmu, name)
        except WiringError as error:
            raise WiringError(f"{where}: {error}") from None
        _refuse_what_cannot_be_set(where, found)
        refuse_other_shape(where, value, found)
        given = value if isinstance(value, tuple) else (value,)
        if len(given) != len(found):
            raise WiringError(
                f"{where}: {len(found)} values expected, {len(given)} given"
            )
        if len(given) > 1:
            _refuse_without_order(where, found)
        for port, one in zip(found, given, strict=True):
            v = port.variable
            known = declared(v) or [None] * v.size
            _, values = whole.setdefault(v.name, (v, known))
            values[port.element] = held(where, port, one, fmu.fmi_major)
    return tuple(_complete(component.name, *written) for written in whole.values())


def _refuse_what_cannot_be_set(where: str, found: Sequence[Port]) -> None:
    for port in found:
        v = port.variable
        settable = v.causality in ("parameter", "input", "structuralParameter")
        settable = settable or v.initial in ("exact", "approx")
        if not settable or v.variability == "constant":
            raise WiringError(
                f"{where}: a {v.variability} {v.causality} of the FMU cannot be set"
            )


def _refuse_without_order(where: str, found: Sequence[Port]) -> None:
    """Refuse a list of values where positions do not say which value is whose."""
    at = [indices_of(port.label) for port in found]
    lengths = {len(index) for index in at if index is not None}
    if None not in at and len(lengths) == 1:
        spans = [range(min(n), max(n) + 1) for n in zip(*filter(None, at), strict=True)]
        if at == list(product(*spans)) and all(span[0] in (0, 1) for span in spans):
            return
    labels = ", ".join(port.label for port in found[:4])
    raise WiringError(
        f"{where}: a list of values goes by index, and this is no array without gaps "
        f"but {labels}{', ...' if len(found) > 4 else ''}; give each value by its name"
    )


def _complete(
    component: str, variable: FmuVariable, values: list[Held | None]
) -> Written:
    """Return all values of a variable, of which some may be the FMU's own.

    Raises:
        WiringError: some are neither given nor known.
    """
    known = tuple(value for value in values if value is not None)
    if len(known) < len(values):
        raise WiringError(
            f"components.{component}: {variable.name} has {variable.size} values, and "
            f"its FMU does not say those that are not given; give all of them"
        )
    return variable, known


def declared(variable: FmuVariable) -> list[Held | None]:
    """Return a variable's start values as its FMU declares them, none if it does not.

    One value stands for all of an array (FMI 3.0).
    """
    words = variable.declared.starts
    if len(words) == 1:
        words *= variable.size
    if len(words) != variable.size:
        return []
    return [declared_value(variable, word) for word in words]


def declared_value(variable: FmuVariable, word: str) -> Held:
    """Return a start value as a model description writes it."""
    if variable.sort == "string":
        return word
    if variable.sort == "binary":
        return bytes.fromhex(word)
    if variable.sort == "boolean":
        return int(word in ("true", "1"))
    return int(word) if variable.sort == "integer" else float(word)
