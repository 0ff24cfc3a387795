"""Start values of a scenario's variables, and where they come from.

They are found by the numbers that a name stands for, as they are written to the FMU:
``plant.v[1]`` is the first of ``plant.v``, and what a map calls otherwise is the same.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from orchestrator.errors import ScenarioError, WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.laid import held_on
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.start_values import declared_value
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import Unit, unit_of
from orchestrator.system import Component, Value, split_name

Part: TypeAlias = tuple[Component, FmuDescription]


class Values:
    """Values by precedence FMU < design < scenario, of components found on demand.

    ``part`` returns a component and its FMU by name; ``designed`` grows as the
    design steps are carried out.
    """

    def __init__(self, known: Sequence[str], part: Callable[[str], Part]) -> None:
        self._known = known
        self._part = part
        self.designed: dict[str, dict[str, Value]] = {name: {} for name in known}

    def value(self, name: str) -> Value:
        """Return the value of ``component.parameter``, a flat tuple if an array.

        Raises:
            ScenarioError: there is none.
        """
        part, fmu, found, variable = self._find(name)
        over = part.values
        under = {k: v for k, v in self.designed[part.name].items() if k not in over}
        try:
            held = held_on(part, fmu, found, {**under, **over})
        except WiringError as error:
            raise ScenarioError(str(error)) from None
        values = tuple(
            _start(port) if one is None else one
            for port, one in zip(found, held, strict=True)
        )
        whole = isinstance(over.get(variable, under.get(variable)), tuple)
        return values if len(values) > 1 or whole else values[0]

    def quantity(self, name: str) -> Quantity:
        """Return the value and unit of a scalar ``component.parameter``.

        Raises:
            ScenarioError: there is none, or it is an array or a text.
        """
        value = self.value(name)
        if isinstance(value, tuple):
            raise ScenarioError(f"{name} is an array; name one number")
        if isinstance(value, str):
            raise ScenarioError(f'{name} is the text "{value}"; name a number')
        return Quantity(float(value), self.unit(name))

    def refuse_text(self, name: str) -> None:
        """Raise ``ScenarioError`` if ``component.variable`` is a String or Binary."""
        for port in self._find(name)[2]:
            if port.variable.is_text:
                raise ScenarioError(
                    f"{name} is {port.variable.kind}, which is not recorded and has "
                    f"no figure; name a number"
                )

    def unit(self, name: str) -> Unit:
        """Return the unit of ``component.variable`` on our side, ``1`` without.

        Raises:
            ScenarioError: there is no such variable.
        """
        _, _, found, _ = self._find(name)
        return found[0].unit or unit_of("1")

    def has(self, name: str) -> bool:
        """Tell whether there is such a variable."""
        try:
            self._find(name)
        except ScenarioError:
            return False
        return True

    def _find(self, name: str) -> tuple[Component, FmuDescription, list[Port], str]:
        component, variable = split_name(name)
        if component not in self._known:
            remedy = did_you_mean(component, self._known)
            raise ScenarioError(
                f"{name}: there is no component {component!r}; {remedy}"
            )
        part, fmu = self._part(component)
        try:
            return part, fmu, ports(part, fmu, variable), variable
        except WiringError as error:
            raise ScenarioError(str(error)) from None


def _start(port: Port) -> float | str:
    words = port.variable.declared.starts
    if not words:
        raise ScenarioError(f"{port.full_name} has no start value in its FMU")
    word = words[port.element if len(words) > 1 else 0]
    if port.variable.is_text:
        return word
    theirs, affine = declared_value(port.variable, word), port.to_ours
    assert not isinstance(theirs, str | bytes)
    return affine.gain * theirs + affine.offset if affine.converts else theirs
