"""The tables behind a fused loop that runs without Python: memory, start, timetable."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from orchestrator.fmu.ports import Affine
from orchestrator.master.fused.memory import capacity
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.quantities.unit import Unit

Role = Literal["input", "output", "parameter"]


@dataclass(frozen=True)
class Outside:
    """A variable of the whole: where its number stands, and what is told of it.

    ``affine`` leads from the number inside to that of an output, and from that of an
    input to the number inside; ``start`` is on the outer side.
    """

    name: str
    role: Role
    place: str
    affine: Affine
    unit: Unit | None
    boolean: bool
    start: float | None
    description: str


def base_values(own: Own) -> NDArray[np.float64]:
    """Return a component's values before initialisation, as its FMU holds them."""
    values = np.array(own.equations.start[: own.equations["size"]], dtype=float)
    for variable, given in own.part.start:
        values[variable.reference : variable.reference + variable.size] = given
    return values


def tables(
    source: Source,
    starts: Mapping[str, NDArray[np.float64]],
    outside: Iterable[Outside],
) -> str:
    """Return the C of everything that the loop works on."""
    return "\n".join(
        [
            *_memory(source, starts),
            *_bound(source),
            *_started(source, starts),
            *_timetable(source),
            *_variables(list(outside)),
            "",
        ]
    )


def _memory(source: Source, starts: Mapping[str, NDArray[np.float64]]) -> Iterator[str]:
    yield "#include <stddef.h>"
    yield "typedef struct {"
    yield "    Engine e;"
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
        for j, delay in enumerate(equations.delays):
            tau = float(starts[own.part.name][delay[1]])
            room = capacity(equations, delay, tau)
            yield f"    V changes_{i}_{j}[{room}];"
            yield f"    double times_{i}_{j}[{room}];"
    yield "} Memory;"


def _bound(source: Source) -> Iterator[str]:
    yield "static void bind_memory(Memory *m) {"
    yield "    m->e.vector = m->vector;"
    yield "    m->e.parts = m->parts;"
    yield "    m->e.rows = m->rows;"
    for own in source.own.values():
        i = own.index
        yield f"    m->parts[{i}].values = m->values_{i};"
        yield f"    m->parts[{i}].held = m->held_{i};"
        if own.equations.delays:
            yield f"    m->parts[{i}].lines = m->lines_{i};"
        for j, _ in enumerate(own.equations.delays):
            line = f"m->lines_{i}[{j}]"
            yield f"    {line}.values = m->changes_{i}_{j};"
            yield f"    {line}.times = m->times_{i}_{j};"
            room = f"sizeof m->changes_{i}_{j} / sizeof *m->changes_{i}_{j}"
            yield f"    {line}.capacity = {room};"
    yield "}"


def _started(
    source: Source, starts: Mapping[str, NDArray[np.float64]]
) -> Iterator[str]:
    tick = source.timetable.schedule.tick
    for own in source.own.values():
        numbers = starts[own.part.name]
        yield f"static const double start_{own.index}[] = {{{_doubles(numbers)}}};"
    yield "static void start_values(Memory *m) {"
    yield f"    m->e.tick_num = {tick.numerator};"
    yield f"    m->e.tick_den = {tick.denominator};"
    yield "    m->e.alive = 1;"
    for own in source.own.values():
        i = own.index
        yield f"    memcpy(m->values_{i}, start_{i}, sizeof start_{i});"
    yield "}"
    names = ", ".join(f'"{name}"' for name in source.parts)
    yield f"static const char *const part_names[] = {{{names}}};"


def _timetable(source: Source) -> Iterator[str]:
    yield "typedef struct {"
    yield "    int64_t first, length, repeats;"
    yield "    const int64_t *offsets;"
    yield "    const int32_t *programs;"
    yield "    size_t n;"
    yield "} Stretch;"
    lines = []
    for i, stretch in enumerate(source.timetable.stretches()):
        offsets = ", ".join(f"{o}" for o in stretch.offsets)
        numbers = ", ".join(f"{source.programs[p]}" for p in stretch.entries)
        yield f"static const int64_t offsets_{i}[] = {{{offsets}}};"
        yield f"static const int32_t programs_{i}[] = {{{numbers}}};"
        head = f"{stretch.first}, {stretch.length}, {stretch.repeats}"
        lines.append(
            f"    {{{head}, offsets_{i}, programs_{i}, {len(stretch.offsets)}}},"
        )
    yield "static const Stretch stretches[] = {"
    yield from lines
    yield "};"
    yield f"enum {{ N_STRETCHES = {len(lines)} }};"
    yield f"#define LAST INT64_C({source.timetable.schedule.stop})"


def _variables(outside: Sequence[Outside]) -> Iterator[str]:
    yield "enum { INPUT, OUTPUT, PARAMETER };"
    yield "typedef struct {"
    yield "    size_t place;"
    yield "    double gain, offset;"
    yield "    int kind, boolean, converts;"
    yield "} Variable;"
    yield "static const Variable variables[] = {"
    for one in outside:
        affine = one.affine
        numbers = f"{affine.gain.hex()}, {affine.offset.hex()}"
        kind = one.role.upper()
        flags = f"{kind}, {int(one.boolean)}, {int(affine.converts)}"
        yield f"    {{offsetof(Memory, {one.place}), {numbers}, {flags}}},"
    yield "};"
    yield f"enum {{ N_VARIABLES = {len(outside)} }};"


def _doubles(numbers: NDArray[np.float64]) -> str:
    return ", ".join(float(number).hex() for number in numbers)
