"""A checked system laid out on one vector of places.

Every part owns contiguous places: its connected inputs, its read variables
as the FMU gives them (raw), and, with a latency, the published ones.  Copies
carry published values to inputs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby
from typing import TypeAlias

from orchestrator.fmu.description import Dtype, FmuDescription, FmuVariable
from orchestrator.fmu.ports import Affine, Port
from orchestrator.fmu.start_values import Written, start_values
from orchestrator.master.places import Copy
from orchestrator.quantities.instants import Instants
from orchestrator.quantities.unit import Unit, unit_of
from orchestrator.system import Component, Fault, Kind, System

Link: TypeAlias = tuple[Port, Port, Affine]  # from an output to an input


@dataclass(frozen=True)
class Edge:
    """One connection, for ordering and listing; names without component."""

    source: str
    output: str
    sink: str
    input: str


@dataclass(frozen=True)
class Part:
    """A component with its places in the vector.

    ``read[:delayed]`` are outputs, which a latency delays; the rest (states,
    parameters that are recorded) are published at once.  ``heard`` are inputs that
    texts travel to.
    """

    component: Component
    fmu: FmuDescription
    kind: Kind
    inputs: tuple[FmuVariable, ...]
    first_input: int
    read: tuple[FmuVariable, ...]
    raw: int
    published: int
    delayed: int
    start: tuple[Written, ...]
    copies: tuple[Copy, ...]
    heard: frozenset[str] = frozenset()

    @property
    def name(self) -> str:
        return self.component.name

    @property
    def splits(self) -> bool:
        """Tell whether its steps are split where what it reads is published."""
        wanted = self.component.split is not False
        return self.kind == "continuous" and self.fmu.variable_step and wanted

    @property
    def read_size(self) -> int:
        return sum(v.size for v in self.read)

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First place and end, from ``raw`` on, of the doubles among what is read."""
        spans, first = [], 0
        for doubles, same in groupby(self.read, key=lambda v: v.dtype == "float64"):
            end = first + sum(v.size for v in same)
            spans += [(first, end)] if doubles else []
            first = end
        return tuple(spans)

    @property
    def input_size(self) -> int:
        return sum(v.size for v in self.inputs)


@dataclass(frozen=True)
class Faulty:
    """A place of an input that has faults, and the edge that brings its value.

    ``affine`` leads from our side of the input to the FMU's.
    """

    edge: Edge
    place: int
    dtype: Dtype
    affine: Affine
    faults: tuple[Fault, ...]


@dataclass(frozen=True)
class Injected:
    """A place of an input to which values, in the FMU's numbers, are added.

    ``of`` is the component at whose instants this happens: the source of the
    connection, or the component itself if nothing drives the input.
    """

    of: str
    component: str
    place: int
    values: tuple[float, ...]

    @property
    def driven(self) -> bool:
        return self.of != self.component


@dataclass(frozen=True)
class Group:
    """Parts that are stepped together until what ``inner`` copies agrees at both ends.

    ``members`` in the order of the system; ``tolerance`` is of a number, or of 1.
    """

    name: str
    members: tuple[str, ...]
    inner: tuple[Copy, ...]
    tolerance: float


@dataclass(frozen=True)
class Said:
    """A text that travels, from an output to an input of the same type and size."""

    source: str
    output: FmuVariable
    sink: str
    input: FmuVariable

    @property
    def ends(self) -> str:
        return f"{self.source}.{self.output.name} -> {self.sink}.{self.input.name}"


@dataclass(frozen=True)
class Column:
    """A recorded number: its name and unit, where it stands, when it is published.

    ``published`` is None for what does not change.
    """

    name: str
    unit: Unit
    index: int
    affine: Affine
    published: Instants | None
    dtype: Dtype = "float64"


@dataclass(frozen=True)
class Wiring:
    """A system ready to be scheduled; ``tables`` groups the columns by row period.

    ``warnings`` are what of it is a guess, ``notes`` what is only worth knowing.
    """

    system: System
    parts: Mapping[str, Part]
    edges: tuple[Edge, ...]
    tables: Mapping[Fraction, tuple[Column, ...]]
    size: int
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    faulty: tuple[Faulty, ...] = ()
    injected: tuple[Injected, ...] = ()
    groups: tuple[Group, ...] = ()
    texts: tuple[Said, ...] = ()

    def group_of(self, name: str) -> Group | None:
        """Return the group that a component is iterated in."""
        return next((g for g in self.groups if name in g.members), None)


def kind_of(component: Component, fmu: FmuDescription) -> Kind:
    """Return how a component is treated: as the scenario, else the FMU says."""
    said = component.kind or fmu.kind
    return said or ("continuous" if fmu.clock is None else "sampled")


class Layout:
    """Hands out places in the vector."""

    def __init__(
        self,
        system: System,
        fmus: Mapping[str, FmuDescription],
        links: Sequence[Link],
        recorded: Mapping[str, Sequence[Port]],
        injected: Sequence[Port] = (),
    ) -> None:
        self.system, self.fmus, self.size = system, fmus, 0
        self.links = [link for link in links if not link[0].variable.is_text]
        self.heard = [t for s, t, _ in links if s.variable.is_text]
        self.input_at: dict[tuple[str, str], int] = {}
        self.read_at: dict[tuple[str, str], int] = {}
        self.places: dict[str, tuple[int, int, int, int]] = {}
        self.inputs: dict[str, tuple[FmuVariable, ...]] = {}
        self.read: dict[str, tuple[FmuVariable, ...]] = {}
        sinks = [*(t for _, t, _ in self.links), *injected]
        self.source_of = {
            (t.component, t.variable.name, t.element): s.component
            for s, t, _ in self.links
        }
        driven = {(t.component, t.variable.name) for t in sinks}
        asked = [p for found in recorded.values() for p in found]
        wanted = [s for s, _, _ in self.links]
        wanted += [p for p in asked if (p.component, p.variable.name) not in driven]
        for name in system.components:
            self._place(name, sinks, wanted)

    def _place(self, name: str, sinks: list[Port], wanted: list[Port]) -> None:
        inputs = _variables(name, sinks)
        read = _variables(name, wanted)
        sources = {s.variable.name for s, _, _ in self.links if s.component == name}
        outputs = [v for v in read if v.causality == "output" or v.name in sources]
        read = (*outputs, *(v for v in read if v not in outputs))
        self.inputs[name], self.read[name] = inputs, read
        first_input = self._take(self.input_at, name, inputs)
        raw = self.size
        published = self._take(self.read_at, name, read)
        if self.system.components[name].latency:
            raw = self.size
            self.size += self.size - published
        delayed = sum(v.size for v in outputs)
        self.places[name] = (first_input, raw, published, delayed)

    def _take(
        self,
        places: dict[tuple[str, str], int],
        name: str,
        variables: tuple[FmuVariable, ...],
    ) -> int:
        first = self.size
        for variable in variables:
            places[name, variable.name] = self.size
            self.size += variable.size
        return first

    def part(self, name: str) -> Part:
        component, fmu = self.system.components[name], self.fmus[name]
        first_input, raw, published, delayed = self.places[name]
        copies = tuple(
            Copy(
                self.read_at[name, s.variable.name] + s.element,
                self.input_at[t.component, t.variable.name] + t.element,
                affine,
                s.variable.dtype,
                t.variable.dtype,
                f"{s.full_name} -> {t.full_name}",
                t.whole,
            )
            for s, t, affine in self.links
            if s.component == name
        )
        return Part(
            component,
            fmu,
            kind_of(component, fmu),
            self.inputs[name],
            first_input,
            self.read[name],
            raw,
            published,
            delayed,
            start_values(component, fmu),
            copies,
            frozenset(t.variable.name for t in self.heard if t.component == name),
        )

    def column(self, port: Port) -> Column:
        key = (port.component, port.variable.name)
        index = self.input_at[key] if key in self.input_at else self.read_at[key]
        place, dtype = index + port.element, port.variable.dtype
        unit, published = port.unit or unit_of("1"), self._published(port)
        return Column(port.full_name, unit, place, port.to_ours, published, dtype)

    def _published(self, port: Port) -> Instants | None:
        """Return when a value changes: an input when its source is published."""
        key = (port.component, port.variable.name, port.element)
        changes = port.variable.causality != "input"
        changes &= port.variable.variability not in ("constant", "fixed")
        owner = self.source_of.get(key, port.component if changes else None)
        if owner is None:
            return None
        component = self.system.components[owner]
        return Instants(component.period, component.offset)


def _variables(component: str, asked: Sequence[Port]) -> tuple[FmuVariable, ...]:
    """Return the distinct variables of a component, doubles first, then by type."""
    found = {p.variable.name: p.variable for p in asked if p.component == component}
    doubles = ("Real", "Float64")
    return tuple(
        sorted(found.values(), key=lambda v: (v.fmi_type not in doubles, v.fmi_type))
    )
