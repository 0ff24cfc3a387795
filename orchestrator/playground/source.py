"""The C of a composition at several rates and latencies, as one module for a browser.

The equations are written once; each variant has its own programs, initialisation and
loop (``orchestrator.master.fused.source``), renamed.  All memory is static: the page
writes the values of the components, asks for a variant and reads its rows.

    play_values(part)            where a component's values are
    play_rows(table)             where the rows of a table are, row by row
    play_run(variant)            1 if it ran to its end, else 0
    play_failure, play_part      as engine.h says; play_at the seconds
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fmus.equations import Equations
from orchestrator.errors import SimulationError
from orchestrator.master.fused.executor import fusible
from orchestrator.master.fused.memory import capacity
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.master.timetable import Timetable, table_name

MOST_OFFSETS = 4096  # instants of a stretch that are written out
RENAMED = (
    *("carry_out_program", "settle", "sweep", "engine_adopt", "engine_start"),
    *("engine_run", "engine_lanes", "engine_size"),
)
HEAD = """\
#include "engine.h"
#undef EXPORTED
#define EXPORTED static
#define PLAYED __attribute__((visibility("default")))
"""


class Variant(Source):
    """One timetable in the module; its models are functions, called and not inlined.

    Raises:
        SimulationError: a component is none of ours, or the timetable has what a page
            does not carry out; the message says what.
    """

    def __init__(self, timetable: Timetable) -> None:
        found, whys = fusible(timetable.wiring.parts)
        told = [f"{name} {why}" for name, why in whys.items()]
        wiring = timetable.wiring
        told += ["it has faults"] * bool(wiring.faulty)
        told += ["it has injections"] * bool(wiring.injected)
        if told:
            raise SimulationError("a page cannot run this: " + "; ".join(told))
        self.columns = {
            table_name(period): columns for period, columns in wiring.tables.items()
        }
        places = {name: [c.index for c in of] for name, of in self.columns.items()}
        super().__init__(timetable, found, places)
        self._often = {own.model for own in self.own.values()}

    def models(self) -> list[str]:
        """Return the lines of the equations, the same for all variants."""
        return list(self._models())

    def rows(self) -> dict[str, int]:
        """Return how many rows each table has."""
        count = dict.fromkeys(self.columns, 0)
        for stretch in self.timetable.stretches():
            for program in stretch.entries:
                for op in program:
                    if op.code == "row":
                        count[op.target] += stretch.repeats
        return count

    def lines(self, number: int) -> Iterator[str]:
        """Write its programs and ``play_<number>``, which carries out all instants."""
        programs = [f"program_{n}" for n in self.programs.values()]
        names = [*RENAMED, *programs]
        yield from (f"#define {name} {name}_of_{number}" for name in names)
        for program, n in self.programs.items():
            yield from self._program(n, program, {})
        yield from self._dispatch()
        yield from self._adopted()
        yield from self._start()
        yield '#include "run.h"'
        yield from self._played(number)
        yield from (f"#undef {name}" for name in names)

    def _played(self, number: int) -> Iterator[str]:
        stretches = list(self.timetable.stretches())
        for i, stretch in enumerate(stretches):
            if len(stretch.offsets) > MOST_OFFSETS:
                raise SimulationError(
                    f"a page cannot run this: {len(stretch.offsets):,} instants pass "
                    f"before anything repeats; choose rates that divide each other"
                )
            offsets = ", ".join(map(str, stretch.offsets))
            programs = ", ".join(str(self.programs[p]) for p in stretch.entries)
            yield f"static const int64_t offsets_{number}_{i}[] = {{{offsets}}};"
            yield f"static const int32_t programs_{number}_{i}[] = {{{programs}}};"
        tick = self.timetable.schedule.tick
        yield f"static int play_{number}(Engine *e) {{"
        yield f"    e->tick_num = {tick.numerator};"
        yield f"    e->tick_den = {tick.denominator};"
        yield "    if (!engine_start(e)) return 0;"
        for i, stretch in enumerate(stretches):
            n, total = len(stretch.offsets), len(stretch.offsets) * stretch.repeats
            yield f"    if (engine_run(e, {stretch.first}, {stretch.length},"
            yield f"            offsets_{number}_{i}, programs_{number}_{i},"
            yield f"            {n}, 0, {total}) < {total}) return 0;"
        yield "    return 1;"
        yield "}"


@dataclass(frozen=True)
class Longest:
    """A dead time that may be set: component, its parameter and the longest (s)."""

    component: str
    parameter: str
    tau: float


def text(variants: Sequence[Variant], longest: Sequence[Longest] = ()) -> str:
    """Return the source of one module with all variants.

    Raises:
        SimulationError: the variants differ in more than rates and latencies.
    """
    models = variants[0].models()
    for variant in variants[1:]:
        if variant.models() != models:
            raise SimulationError(
                "a page cannot run this: its equations change with rate or latency"
            )
    parts = [HEAD, *models, *_memory(variants, longest)]
    for number, variant in enumerate(variants):
        parts += _once(variant.lines(number), number)
    parts += _exported(variants)
    return "\n".join([*parts, ""])


def _once(lines: Iterator[str], number: int) -> list[str]:
    """Drop from all but the first variant what may stand in a module only once."""
    if number == 0:
        return list(lines)
    return [line for line in lines if not line.startswith("enum { CIRCLE")]


def _memory(variants: Sequence[Variant], longest: Sequence[Longest]) -> Iterator[str]:
    first = variants[0]
    vector = max(1, *(v.wiring.size for v in variants))
    yield f"static V vector[{vector}];"
    for name, own in first.own.items():
        i, equations = own.index, own.equations
        yield f"static V values_{i}[{equations['size'] + equations['n_d']}];"
        held = max(v.own[name].part.component.latency for v in variants)
        yield f"static V held_{i}[{max(1, held * own.part.delayed)}];"
        for j, delay in enumerate(equations.delays):
            room = _room(name, own, equations, delay, longest)
            yield f"static V line_{i}_{j}[{room}];"
            yield f"static double times_{i}_{j}[{room}];"
        if equations.delays:
            yield f"static Line lines_{i}[{len(equations.delays)}];"
    for i, table in enumerate(first.columns):
        rows = max(v.rows()[list(v.columns)[i]] for v in variants)
        yield f"static V rows_{i}[{max(1, rows * len(first.columns[table]))}];"
    yield f"static Instance parts[{len(first.parts)}];"
    yield f"static Rows rows[{max(1, len(first.columns))}];"
    yield "static Engine engine;"


def _room(
    name: str,
    own: Own,
    equations: Equations,
    delay: tuple[int, int, int],
    longest: Sequence[Longest],
) -> int:
    tau = equations.start[delay[1]]
    for one in longest:
        variable = own.part.fmu.variables.get(one.parameter)
        if one.component == name and variable and variable.reference == delay[1]:
            tau = max(tau, one.tau)
    return capacity(equations, delay, tau)


def _exported(variants: Sequence[Variant]) -> Iterator[str]:
    first = variants[0]
    yield "PLAYED double *play_values(int part) {"
    yield "    switch (part) {"
    for own in first.own.values():
        yield f"    case {own.index}: return values_{own.index};"
    yield "    default: return NULL;"
    yield "    }"
    yield "}"
    yield "PLAYED double *play_rows(int table) { return rows[table].values; }"
    yield "PLAYED int play_failure(void) { return engine.failure; }"
    yield "PLAYED int play_part(void) { return engine.part; }"
    yield "PLAYED double play_at(void) { return seconds_of(&engine, engine.instant); }"
    yield "PLAYED int play_run(int variant) {"
    yield "    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++)"
    yield "        vector[i] = 0;"
    for own in first.own.values():
        i = own.index
        here = f"parts[{i}]"
        yield f"    {here}.values = values_{i};"
        yield f"    {here}.held = held_{i};"
        yield f"    {here}.head = 0;"
        yield f"    {here}.wrong = 0;"
        yield f"    {here}.failure = FINE;"
        for j, delay in enumerate(own.equations.delays):
            line = f"lines_{i}[{j}]"
            yield f"    {line}.values = line_{i}_{j};"
            yield f"    {line}.times = times_{i}_{j};"
            yield f"    {line}.capacity = sizeof line_{i}_{j} / sizeof(V);"
            assert delay
        if own.equations.delays:
            yield f"    {here}.lines = lines_{i};"
    for i in range(len(first.columns)):
        yield f"    rows[{i}].values = rows_{i};"
        yield f"    rows[{i}].count = 0;"
    yield "    engine.vector = vector;"
    yield "    engine.parts = parts;"
    yield "    engine.rows = rows;"
    yield "    engine.alive = 1;"
    yield "    engine.failure = FINE;"
    yield "    switch (variant) {"
    for number in range(len(variants)):
        yield f"    case {number}: return play_{number}(&engine);"
    yield "    default: return 0;"
    yield "    }"
    yield "}"
