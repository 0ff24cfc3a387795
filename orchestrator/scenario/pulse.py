"""How two FMUs answer one short pulse: the sign and the ratio of their variables.

Each input gets, in an FMU alone, a pulse of half the steps; what the outputs do
beside a run without it is the answer.  Two answers are compared by the gain that
fits one to the other best, and by how alike they are (the cosine between them).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FeedDriveError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.start_values import start_values
from orchestrator.master.stepper import Stepper
from orchestrator.scenario.compose import Composition
from orchestrator.system import Component, Value, split_name

STEPS = 40
SIZES = (1.0, 10.0, 100.0, 1000.0)  # in our unit, until both answer
ALIKE = 1e-6  # of a whole: answers of one law

Answer = NDArray[np.float64]


@dataclass(frozen=True)
class Subject:
    """An FMU to be measured, the values it starts with and its step (s)."""

    fmu: FmuDescription
    period: Fraction
    values: Mapping[str, Value]


@dataclass(frozen=True)
class Measured:
    """Their output answers a pulse ``ratio`` times as ours does, in FMU units.

    ``likeness`` is 1 where one answer is a multiple of the other.
    """

    input: str
    output: str
    ratio: float
    likeness: float

    @property
    def is_exact(self) -> bool:
        return 1 - self.likeness < ALIKE


def measure(
    ours: Subject,
    theirs: Subject,
    inputs: Sequence[tuple[FmuVariable, FmuVariable, float]],
    outputs: Sequence[tuple[FmuVariable, FmuVariable]],
) -> list[Measured]:
    """Return the pairs of inputs and outputs of which both FMUs give an answer.

    Inputs come with what 1 of our unit is in theirs.  Nothing is measured where an
    FMU cannot be run: refused, out of bounds, or not of this machine.
    """
    both = (ours, [o.name for o, _ in outputs]), (theirs, [o.name for _, o in outputs])
    found = []
    try:
        still = [_run(subject, names, None) for subject, names in both]
        for mine, other, unit in inputs:
            for size in SIZES:
                pulses = (mine.name, size), (other.name, size * unit)
                moved = [
                    _run(subject, names, pulse) - rest
                    for (subject, names), pulse, rest in zip(
                        both, pulses, still, strict=True
                    )
                ]
                told = [
                    Measured(mine.name, out.name, *_compared(a, b))
                    for (out, _), a, b in zip(
                        outputs, *(m.T for m in moved), strict=True
                    )
                    if np.any(a) and np.any(b) and np.all(np.isfinite((a, b)))
                ]
                found += told
                if told:
                    break
    except FeedDriveError:
        return found
    return found


def answers(before: Composition, after: Composition, component: str) -> list[Measured]:
    """Return how a swapped component answers what drives it, beside the original.

    Names and ratios are ours, in our units: 1 is the same, below 0 reversed.
    """
    old, new = (_Side.of(composition, component) for composition in (before, after))
    ends = before.system.connections
    driven = [n for owner, n in map(split_name, ends) if owner == component]
    sources = (*ends.values(), *before.system.record)
    read = dict.fromkeys(n for o, n in map(split_name, sources) if o == component)
    pairs = {n: (a, b) for n in (*driven, *read) if (a := old[n]) and (b := new[n])}
    ours = {a.variable.name: name for name, (a, _) in pairs.items()}
    inputs = [
        (a.variable, b.variable, b.to_theirs.gain / a.to_theirs.gain)
        for name, (a, b) in pairs.items()
        if name in driven
    ]
    outputs = [
        (a.variable, b.variable)
        for a, b in pairs.values()
        if a.variable.causality == b.variable.causality == "output"
    ]
    found = []
    for one in measure(old.subject, new.subject, inputs, outputs):
        name = ours[one.output]
        a, b = pairs[name]
        ratio = one.ratio * b.to_ours.gain / a.to_ours.gain
        ends_of = f"{component}.{ours[one.input]}", f"{component}.{name}"
        found.append(Measured(*ends_of, ratio, one.likeness))
    return found


@dataclass(frozen=True)
class _Side:
    """A component of one composition."""

    component: Component
    fmu: FmuDescription

    @classmethod
    def of(cls, composition: Composition, name: str) -> "_Side":
        return cls(composition.system.components[name], composition.fmus[name])

    @property
    def subject(self) -> Subject:
        values: dict[str, Value] = {}
        for variable, written in start_values(self.component, self.fmu):
            numbers = tuple(n for n in written if not isinstance(n, bytes))
            if numbers:
                values[variable.name] = numbers if len(numbers) > 1 else numbers[0]
        return Subject(self.fmu, self.component.period, values)

    def __getitem__(self, name: str) -> Port | None:
        """Return the one real number that a name stands for."""
        found = ports(self.component, self.fmu, name)
        return (
            found[0] if len(found) == 1 and found[0].variable.sort == "real" else None
        )


def signs(measured: Sequence[Measured]) -> dict[str, float]:
    """Return +1 or -1 for every input and output, the fewest -1 that explain all.

    A name is left out where answers contradict one another.
    """
    found: dict[str, float] = {}
    for first in dict.fromkeys(one.output for one in measured):
        if first in found:
            continue
        group = {first: 1.0}
        for _ in measured:  # what hangs together is reached within as many rounds
            for one in measured:
                sign = float(np.sign(one.ratio))
                for a, b in ((one.input, one.output), (one.output, one.input)):
                    if a in group:
                        group.setdefault(b, sign * group[a])
        flips = [
            (sum(way * s < 0 for s in group.values()), way * group[first] < 0, way)
            for way in (1.0, -1.0)
        ]
        way = min(flips)[2]
        found |= {name: way * sign for name, sign in group.items()}
    for one in measured:
        if found.get(one.input, 1) * found.get(one.output, 1) * one.ratio < 0:
            found.pop(one.input, None)
    return found


def _run(
    subject: Subject, outputs: Sequence[str], pulse: tuple[str, float] | None
) -> Answer:
    """Return the outputs after every step, (STEPS, outputs)."""
    rows = []
    with Stepper(subject.fmu.path, subject.values) as fmu:
        rest = fmu[pulse[0]] if pulse else 0.0
        for k in range(STEPS):
            if pulse and isinstance(rest, float):  # single numbers are paired
                fmu[pulse[0]] = rest + (pulse[1] if k < STEPS // 2 else 0.0)
            fmu.step(subject.period)
            rows.append([fmu[name] for name in outputs])
    return np.array(rows, dtype=float)


def _compared(ours: Answer, theirs: Answer) -> tuple[float, float]:
    """Return the ratio that fits best, and the cosine between both answers."""
    largest = np.max(np.abs(ours)), np.max(np.abs(theirs))  # squares may underflow
    a, b = ours / largest[0], theirs / largest[1]
    both = float(a @ b)
    likeness = abs(both) / float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(both / (a @ a) * largest[1] / largest[0]), likeness
