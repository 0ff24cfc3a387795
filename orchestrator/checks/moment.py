"""One moment of a run: its knowns moved, its unknowns read.

Knowns are real inputs and, by model exchange, continuous states; unknowns are
outputs that hold numbers and, by model exchange, state derivatives.  Model
exchange is asked in continuous-time mode, where only continuous inputs move.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orchestrator.checks.instance import Instance, Row
from orchestrator.checks.item import WORDS
from orchestrator.checks.laboratory import Laboratory
from orchestrator.fmu.description import FmuVariable


@dataclass(frozen=True)
class Known:
    """An input, or a state that begins at ``place`` in the vector of states."""

    variable: FmuVariable
    place: int | None = None

    @property
    def name(self) -> str:
        return self.variable.name

    def read(self, one: Instance) -> Row:
        """Return its values, shape (size,)."""
        if self.place is None:
            return np.array(one.get(self.variable), float)
        return one.face.states()[self.place : self.place + self.variable.size]

    def write(self, one: Instance, values: Sequence[float] | Row) -> None:
        if self.place is None:
            one.set(self.variable, [float(v) for v in values])
            return
        states = one.face.states()
        states[self.place : self.place + self.variable.size] = values
        one.face.set_states(states)

    def moved(self, values: Row, part: float) -> Row:
        """Return values moved by ``part`` (-1 to 1) of a tenth, within bounds."""
        variable = self.variable
        low = float(variable.min) if variable.min else -np.inf
        high = float(variable.max) if variable.max else np.inf
        return np.clip(values + 0.1 * part * np.maximum(1, np.abs(values)), low, high)


@dataclass(frozen=True)
class Unknown:
    """An output or derivative; ``kinds`` by known, None where it does not say."""

    variable: FmuVariable
    kinds: Mapping[str, str] | None

    @property
    def name(self) -> str:
        return self.variable.name

    def read(self, one: Instance) -> Row:
        return np.array(one.get(self.variable), float)


def interfaces(lab: Laboratory) -> Iterator[Laboratory]:
    """Give the laboratory, and one by model exchange if there is that as well."""
    yield lab
    other = lab.model.modelExchange
    if lab.kind == "co-simulation" and other is not None:
        description = replace(
            lab.description,
            co_simulation=False,
            model_identifier=other.modelIdentifier,
        )
        yield replace(lab, description=description)


def real_inputs(lab: Laboratory) -> list[Known]:
    return [Known(v) for v in lab.sampled("inputs", lab.excited)]


def knowns(lab: Laboratory) -> list[Known]:
    """Return what an unknown may depend on while stepping."""
    inputs = real_inputs(lab)
    if lab.kind == "co-simulation":
        return inputs
    found = [k for k in inputs if k.variable.variability == "continuous"]
    place = 0
    for derivative in lab.model.derivatives:
        state = lab.description[derivative.variable.derivative.name]
        found.append(Known(state, place))
        place += state.size
    return lab.sampled("inputs and states", found)


def unknowns(lab: Laboratory) -> list[Unknown]:
    """Return outputs, and derivatives by model exchange, with declared kinds."""
    listed = list(lab.model.outputs)
    if lab.kind == "model exchange":
        listed += lab.model.derivatives
    found = []
    for item in lab.sampled("unknowns", listed):
        if item.variable is None or item.variable.type in WORDS:
            continue
        variable = lab.description[item.variable.name]
        found.append(Unknown(variable, _kinds(item)))
    return found


def _kinds(item: Any) -> dict[str, str] | None:
    if item.dependencies is None:
        return None
    given = item.dependenciesKind or ["dependent"] * len(item.dependencies)
    return {d.name: k for d, k in zip(item.dependencies, given, strict=False)}
