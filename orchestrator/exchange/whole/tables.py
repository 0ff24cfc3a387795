"""The tables behind a fused loop that runs without Python: memory, start, timetable."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from orchestrator.exchange.whole.faults import faults_bound, faults_kept, faults_started
from orchestrator.fmu.ports import Affine
from orchestrator.master.fused.memory import LONGEST_LINE, SHORTEST, capacity
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.master.schedule import Stretch
from orchestrator.master.timetable import Program
from orchestrator.quantities.unit import Unit

Role = Literal["parameter", "input", "output", "local"]
Halves = tuple[Program, Program]
Starts = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Outside:
    """A variable of the whole: where its number stands, and what is told of it.

    ``affine`` leads from the number inside to that of an output, and from that of an
    input to the number inside; ``start`` is on the outer side.  ``needs`` are the
    outside inputs that an output depends on within an instant.
    """

    name: str
    role: Role
    place: str
    affine: Affine
    unit: Unit | None
    boolean: bool
    start: float | None
    description: str
    needs: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Tables:
    """All that the loop works on; ``outside`` in the order of their references."""

    source: Source
    stretches: Sequence[Stretch[Halves]]
    starts: Starts
    outside: Sequence[Outside]

    def text(self) -> str:
        """Return the C of it."""
        return "\n".join(
            [
                *self._memory(),
                *self._bound(),
                *self._started(),
                *self._timetable(),
                *self._variables(),
                *self._delays(),
                "",
            ]
        )

    def delays(self) -> Iterator[tuple[Own, int, str, int]]:
        """Yield each dead time: its component, number, parameter, room for changes."""
        for own in self.source.own.values():
            for j, delay in enumerate(own.equations.delays):
                tau = float(self.starts[own.part.name][delay[1]])
                variables = own.part.fmu.variables.values()
                name = next(v.name for v in variables if v.reference == delay[1])
                room = capacity(own.equations, delay, tau)
                yield own, j, f"{own.part.name}.{name}", room

    def _memory(self) -> Iterator[str]:
        source = self.source
        yield "#include <stddef.h>"
        yield '#include "whole.h"'
        yield "typedef struct {"
        yield "    Engine e;"
        yield "    int64_t repeat; /* of the stretch */"
        yield "    size_t stretch, entry;"
        yield "    int64_t open; /* of its instant, half is done */"
        yield f"    Instance parts[{len(source.parts)}];"
        yield f"    Rows rows[{max(1, len(source.tables))}];"
        yield f"    V vector[{max(1, source.wiring.size)}];"
        for own in source.own.values():
            i, equations = own.index, own.equations
            size = equations["size"] + equations["n_d"]
            latency = own.part.component.latency * own.part.delayed
            yield f"    V values_{i}[{size}], held_{i}[{max(1, latency)}];"
            if equations.delays:
                yield f"    Line lines_{i}[{len(equations.delays)}];"
        for name, i in self._foreign():
            yield f"    V values_{i}[{max(1, len(self.starts[name]))}];"
        for own, j, _, room in self.delays():
            yield f"    V changes_{own.index}_{j}[{room}];"
            yield f"    double times_{own.index}_{j}[{room}];"
        yield from faults_kept(source.wiring)
        yield "} Memory;"

    def _bound(self) -> Iterator[str]:
        pointers = {f"e.{name}": f"m->{name}" for name in ("vector", "parts", "rows")}
        for own in self.source.own.values():
            i = own.index
            pointers[f"parts[{i}].values"] = f"m->values_{i}"
            pointers[f"parts[{i}].held"] = f"m->held_{i}"
            if own.equations.delays:
                pointers[f"parts[{i}].lines"] = f"m->lines_{i}"
        for own, j, _, _ in self.delays():
            line = f"lines_{own.index}[{j}]"
            pointers[f"{line}.values"] = f"m->changes_{own.index}_{j}"
            pointers[f"{line}.times"] = f"m->times_{own.index}_{j}"
        for _, i in self._foreign():
            pointers[f"parts[{i}].values"] = f"m->values_{i}"
        pointers |= faults_bound(self.source.wiring)
        pointers["e.kernel"] = "loaded"
        yield "static void bind_memory(Memory *m, void *loaded) {"
        yield from (f"    m->{name} = {to};" for name, to in pointers.items())
        yield "}"
        yield "static void unbind_memory(Memory *m) {"
        yield from (f"    m->{name} = NULL;" for name in pointers)
        yield "}"

    def _started(self) -> Iterator[str]:
        source, tick = self.source, self.source.timetable.schedule.tick
        started = [(name, own.index) for name, own in source.own.items()]
        started += [(n, i) for n, i in self._foreign() if len(self.starts[n])]
        for name, i in started:
            numbers = _doubles(self.starts[name])
            yield f"static const double start_{i}[] = {{{numbers}}};"
        yield f"const int64_t whole_tick_num = {tick.numerator};"
        yield f"const int64_t whole_tick_den = {tick.denominator};"
        yield "static void start_values(Memory *m) {"
        yield "    m->e.tick_num = whole_tick_num;"
        yield "    m->e.tick_den = whole_tick_den;"
        yield "    m->e.alive = 1;"
        for _, i in started:
            yield f"    memcpy(m->values_{i}, start_{i}, sizeof start_{i});"
        for own, j, _, room in self.delays():
            yield f"    m->lines_{own.index}[{j}].capacity = {room};"
        yield from faults_started(source.wiring, tick)
        yield "}"

    def _timetable(self) -> Iterator[str]:
        yield "typedef struct {"
        yield "    int64_t first, length, repeats;"
        yield "    const int64_t *offsets;"
        yield "    const int32_t *first_halves, *second_halves;"
        yield "    size_t n;"
        yield "} Stretch;"
        lines, number = [], self.source.programs
        for i, stretch in enumerate(self.stretches):
            offsets = ", ".join(f"{o}" for o in stretch.offsets)
            yield f"static const int64_t offsets_{i}[] = {{{offsets}}};"
            for which in (0, 1):
                numbers = ", ".join(f"{number[e[which]]}" for e in stretch.entries)
                yield f"static const int32_t halves_{i}_{which}[] = {{{numbers}}};"
            head = f"{stretch.first}, {stretch.length}, {stretch.repeats}"
            names = f"offsets_{i}, halves_{i}_0, halves_{i}_1"
            lines.append(f"    {{{head}, {names}, {len(stretch.offsets)}}},")
        yield "static const Stretch stretches[] = {"
        yield from lines
        yield "};"
        yield f"enum {{ N_STRETCHES = {len(lines)} }};"

    def _variables(self) -> Iterator[str]:
        yield "typedef struct {"
        yield "    size_t place;"
        yield "    double gain, offset;"
        yield "    int converts;"
        yield "} Outer;"
        yield "static const Outer outside[] = {"
        for one in self.outside:
            affine = one.affine
            numbers = f"{affine.gain.hex()}, {affine.offset.hex()}"
            place = f"offsetof(Memory, {one.place})"
            yield f"    {{{place}, {numbers}, {int(affine.converts)}}},"
        yield "};"
        first = {role: self.first(role) for role in ("input", "output", "local")}
        states = len(self.outside) - first["local"]
        yield "enum {"
        yield f"    FIRST_INPUT = {first['input']}, FIRST_OUTPUT = {first['output']},"
        yield f"    FIRST_STATE = {first['local']}, N_STATES = {states},"
        yield f"    N_PARTS = {len(self.source.parts)}"
        yield "};"

    def _delays(self) -> Iterator[str]:
        lines = [
            f"{{{own.equations.numbers['h_max'].hex()}, {room}}}"
            for own, _, _, room in self.delays()
        ]
        yield "static const struct { double h_max, room; } delayed[] = {"
        yield f"    {', '.join(lines or ['{1, 0}'])}"
        yield "};"
        yield f"enum {{ SHORTEST = {SHORTEST}, LONGEST_LINE = {LONGEST_LINE} }};"

    def _foreign(self) -> list[tuple[str, int]]:
        """Return the components that are not compiled in, with their numbers."""
        parts = enumerate(self.source.parts)
        return [(name, i) for i, name in parts if name not in self.source.own]

    def first(self, role: str) -> int:
        """Return the first reference of a role, or the end of what is before it."""
        order = ("parameter", "input", "output", "local")
        before = order[: order.index(role)]
        return sum(one.role in before for one in self.outside)


def base_values(own: Own) -> NDArray[np.float64]:
    """Return a component's values before initialisation, as its FMU holds them."""
    values = np.array(own.equations.start[: own.equations["size"]], dtype=float)
    for variable, given in own.part.start:
        values[variable.reference : variable.reference + variable.size] = given
    return values


def _doubles(numbers: NDArray[np.float64]) -> str:
    return ", ".join(float(number).hex() for number in numbers)
