"""Where each variable of a model stands, in FMI and in memory.

One flat vector of doubles holds everything an FMU shows; a value reference
is an index into it, in FMI 2 and in FMI 3 alike (an FMI 3 array takes the
reference of its first element; FMI 2 names every element ``K[1,2]``):

    parameters | inputs | outputs | states | derivatives | T_s

The blocks lie side by side so that the compiled equations read and write them
in place.  ``derivatives`` is empty for sampled models, ``T_s`` for continuous.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Literal

import numpy as np

from fmus.model import Continuous, Leaf, Model, Record, Var, leaves

Block = Literal["parameter", "input", "output", "state", "derivative", "period"]


@dataclass(frozen=True)
class Variable:
    """One FMI variable: a scalar or an array (rows first).

    ``start`` has one number per element, or is empty where FMI allows none
    (outputs, derivatives).  ``of_state`` is the reference a derivative is of.
    """

    name: str
    reference: int
    shape: tuple[int, ...]
    block: Block
    var: Var
    boolean: bool
    start: tuple[float, ...]
    of_state: int | None = None

    @property
    def size(self) -> int:
        return prod(self.shape)

    def elements(self) -> Iterator[tuple[str, int]]:
        """Yield name and reference of each element, as FMI 2 writes them."""
        if not self.shape:
            yield self.name, self.reference
            return
        indices = product(*(range(1, n + 1) for n in self.shape))
        for offset, index in enumerate(indices):
            written = f"[{','.join(map(str, index))}]"
            if self.of_state is None:
                name = f"{self.name}{written}"
            else:  # the index belongs to the state: der(state.v[1])
                name = f"{self.name[:-1]}{written})"
            yield name, self.reference + offset


@dataclass(frozen=True)
class Layout:
    """All variables of a model, and the first index of each block."""

    variables: tuple[Variable, ...]
    offset: dict[Block, int]
    count: dict[Block, int]

    def __getitem__(self, name: str) -> Variable:
        return next(v for v in self.variables if v.name == name)

    def block(self, block: Block) -> tuple[Variable, ...]:
        return tuple(v for v in self.variables if v.block == block)

    @property
    def size(self) -> int:
        return sum(self.count.values())


def layout(model: Model, output_like: Record) -> Layout:
    """Lay out a model's variables; ``output_like`` gives the output shapes.

    Raises:
        ValueError: two fields of Input, Output and Parameters share a name.
    """
    continuous = isinstance(model, Continuous)
    state = list(leaves(model.state, "state."))
    derivative = [_derivative(leaf) for leaf in state] if continuous else []
    period = [] if continuous else [_period(model)]
    fields: dict[Block, list[Leaf]] = {
        "parameter": list(leaves(model.parameters)),
        "input": list(leaves(model.input)),
        "output": list(leaves(output_like)),
        "state": state,
        "derivative": derivative,
        "period": period,
    }
    variables: list[Variable] = []
    offset: dict[Block, int] = {}
    count: dict[Block, int] = {}
    reference = 0
    for block, block_leaves in fields.items():
        offset[block] = reference
        for leaf in block_leaves:
            of_state = None
            if block == "derivative":
                of_state = reference - offset["derivative"] + offset["state"]
            start = tuple(float(v) for v in np.ravel(leaf.value))
            variables.append(
                Variable(
                    leaf.name,
                    reference,
                    np.shape(leaf.value),
                    block,
                    leaf.var,
                    leaf.boolean,
                    () if block in ("output", "derivative") else start,
                    of_state,
                )
            )
            reference += len(start)
        count[block] = reference - offset[block]
    _refuse_twins(model, variables)
    return Layout(tuple(variables), offset, count)


def _derivative(leaf: Leaf) -> Leaf:
    var = Var(per_second(leaf.var.unit), f"derivative of {leaf.var.description}")
    return Leaf(f"der({leaf.name})", var, leaf.value, False)


def _period(model: Model) -> Leaf:
    assert not isinstance(model, Continuous)
    var = Var("s", "sample time", constant=True)
    return Leaf("T_s", var, float(model.period), False)


def per_second(unit: str) -> str:
    """Return the unit of a time derivative, as models write units."""
    return f"({unit})/s" if {".", "/"} & set(unit) else f"{unit}/s"


def _refuse_twins(model: Model, variables: list[Variable]) -> None:
    seen: dict[str, Block] = {}
    for variable in variables:
        if variable.name in seen:
            raise ValueError(
                f"{model.name}: {variable.block} {variable.name!r} is also the name "
                f"of a {seen[variable.name]}; rename one of them"
            )
        seen[variable.name] = variable.block
