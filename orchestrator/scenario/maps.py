"""What a scenario writes of a foreign FMU's variable, and gains made of parameters.

A gain may be an expression: numbers, ``pi``, parameters of the component by our names,
those of others as ``component.parameter``, ``*``, ``/``, ``-`` in front, parentheses.
It is worked out with units from the values the run begins with.  Without ``unit`` our
side has the unit that comes of it, with one it is converted.
"""

import ast
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isfinite, pi
from typing import Any, TypeAlias

from pydantic import Field, field_validator, model_validator

from fmus.units import UnitError
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.evaluation.schema import Strict
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.ports import Port, is_inward, ports
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import (
    Unit,
    conversion,
    product_unit,
    quotient_unit,
    unit_of,
)
from orchestrator.system import Component, Mapped, Range
from orchestrator.warned import warn

Lookup: TypeAlias = Callable[[str], Quantity]


class MapSpec(Strict):
    """A foreign variable under our name: theirs, gain, offset, unit of our side.

    A ``value``, in our unit, is one of the component's parameters.  ``range`` rounds
    into an integer input; ``table`` says what an input of whole numbers gets for each
    that it may be given.
    """

    name: str
    gain: float | str | None = None
    offset: float | None = None
    unit: str | None = None
    range: Range | None = None
    table: dict[str, int] | None = Field(default=None, min_length=1)

    @field_validator("table", mode="before")
    @classmethod
    def _whole_numbers(cls, value: Any) -> Any:
        for key in value if isinstance(value, dict) else ():
            if not re.fullmatch(r"-?\d+", key):
                raise ValueError(f"{key!r}: a table lists whole numbers")
        return value

    @model_validator(mode="after")
    def _table_alone(self) -> "MapSpec":
        others = (self.gain, self.offset, self.unit, self.range)
        if self.table is not None and others != (None,) * 4:
            raise ValueError("a table stands alone: no gain, offset, unit or range")
        return self

    @field_validator("gain")
    @classmethod
    def _passes_something(cls, value: float | str | None) -> float | str | None:
        if isinstance(value, str):
            _parsed(value)
        elif value is not None and (value == 0 or not isfinite(value)):
            raise ValueError(f"{value} is no gain: a finite number other than zero")
        return value

    def mapped(self) -> Mapped:
        """Return it as data; with a gain still to be worked out, only whose it is."""
        if isinstance(self.gain, str):
            return Mapped(self.name, range=self.range)
        table = None
        if self.table is not None:
            table = tuple((int(k), v) for k, v in self.table.items())
        return Mapped(self.name, self.gain, self.offset, self.unit, self.range, table)


def with_gains(
    component: Component,
    specs: Mapping[str, MapSpec],
    fmu: FmuDescription,
    lookup: Lookup,
) -> tuple[Component, frozenset[str]]:
    """Return a component with its gains worked out, and the parameters in them.

    ``lookup`` gives the value of a ``component.parameter``.

    Raises:
        ScenarioError: a parameter is missing, or units do not fit.
    """
    made, taken = dict(component.map), set[str]()
    for name, spec in specs.items():
        if not isinstance(spec.gain, str):
            continue
        where = f"components.{component.name}.map.{name}.gain = {spec.gain!r}"

        def own(written: str) -> Quantity:
            full = written if "." in written else f"{component.name}.{written}"
            taken.add(full)
            return lookup(full)

        try:
            gain = _value(_parsed(spec.gain), own)
            made[name] = _mapped(component, fmu, spec, gain)
        except (UnitError, ValueError, ScenarioError, WiringError) as error:
            raise ScenarioError(f"{where}: {error}") from None
    return replace(component, map=made), frozenset(taken)


def _mapped(
    component: Component, fmu: FmuDescription, spec: MapSpec, gain: Quantity
) -> Mapped:
    (port, *_) = found = ports(replace(component, map={}), fmu, spec.name)
    if any(p.variable.causality not in ("input", "output") for p in found):
        raise ScenarioError("an expression is for inputs and outputs")
    if gain.value == 0 or not isfinite(gain.value):
        raise ScenarioError(f"is {gain.value}; a gain is finite and not zero")
    theirs = port.unit if port.unit is not None and port.unit.base else unit_of("1")
    inward = is_inward(port.variable)
    ours = _ours(port, theirs, gain, inward=inward)
    number = gain.value
    if spec.unit is not None:
        wanted = unit_of(spec.unit)
        step = conversion(wanted, ours) if inward else conversion(ours, wanted)
        if step.offset:
            raise UnitError(f"{ours} and {wanted} differ by an offset")
        for doubt in step.doubts:
            warn(f"components.{component.name}.map: {spec.name}: {doubt}")
        number, ours = gain.value * step.gain, wanted
    return Mapped(spec.name, number, spec.offset, ours, spec.range)


def _ours(port: Port, theirs: Unit, gain: Quantity, *, inward: bool) -> Unit:
    """Return the unit of our side: an input is gain * ours, an output ours / gain."""
    if not inward:
        return product_unit(theirs, gain.unit)
    found = quotient_unit(theirs, gain.unit)
    below = re.fullmatch(r"1/(?:(\w+)|\(([^()]*)\))", str(gain.unit))
    if theirs == "1" and below:  # "mm" instead of "1/(1/mm)"
        return Unit(below[1] or below[2], found.base)
    return found


def _parsed(text: str) -> ast.expr:
    """Return the syntax tree of an expression.

    Raises:
        ValueError: it is none.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError):
        raise ValueError(f"{text!r} is no expression such as 'lead / counts'") from None
    _value(tree, lambda name: Quantity(1.0))
    return tree


def _value(node: ast.expr, parameter: Lookup) -> Quantity:
    match node:
        case ast.Constant(value=int() | float() as number):
            return Quantity(float(number))
        case ast.Name() | ast.Attribute():
            name = ast.unparse(node)
            return Quantity(pi) if name == "pi" else parameter(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            found = _value(operand, parameter)
            return Quantity(-found.value, found.unit)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            a, b = _value(left, parameter), _value(right, parameter)
            return Quantity(a.value * b.value, product_unit(a.unit, b.unit))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            a, b = _value(left, parameter), _value(right, parameter)
            if b.value == 0:
                raise ValueError(f"{ast.unparse(right)} is zero")
            return Quantity(a.value / b.value, quotient_unit(a.unit, b.unit))
    raise ValueError(
        f"{ast.unparse(node)!r}: write numbers, parameters, pi, *, / and parentheses"
    )
