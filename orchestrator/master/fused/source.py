"""A timetable as C: one function per program, our models inlined as equations.

Every operation of a program becomes the statements it means, in its order, on
the places of the vector and the values of each component of ours; operations on
other FMUs stay calls of the kernel.  Parameters, start values, dead times and
rows are data: one source serves every run of its structure, and any number of
lanes W that it is compiled for.

    engine_start   initialisation in lanes (parts in order, circles by substitution)
    engine_run     instants of a stretch, as ``kernel_run``
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

from fmus.equations import Equations
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.ports import Affine
from orchestrator.master.initialise import SUBSTITUTIONS, places_opened
from orchestrator.master.layout import Faulty, Part
from orchestrator.master.order import initial_order
from orchestrator.master.places import Copy
from orchestrator.master.timetable import Op, Program, Timetable, table_name
from orchestrator.native.library import CODES

FEW = 4  # copies of one model that are inlined; more are calls of one function
_CODE = {name: i for i, name in enumerate(CODES)}
_CODE |= {"advance": _CODE["step"], "tick": _CODE["step"]}


@dataclass(frozen=True)
class Own:
    """A component of ours: its number among the parts, its model, its equations."""

    index: int
    model: int
    part: Part
    equations: Equations

    @property
    def function(self) -> str:
        return f"m{self.model}"

    @property
    def instance(self) -> str:
        return f"(e->parts + {self.index})"

    def value(self, reference: int) -> str:
        return f"e->parts[{self.index}].values[{reference}]"


class Source:
    """The C of a timetable; ``programs`` are numbered in the order of first use.

    ``columns`` are the places of the vector that each table records in lanes.
    """

    def __init__(
        self,
        timetable: Timetable,
        equations: Mapping[str, Equations],
        columns: Mapping[str, Sequence[int]],
    ) -> None:
        self.timetable, self.wiring = timetable, timetable.wiring
        self._columns = columns
        distinct: dict[int, int] = {}
        for found in equations.values():
            distinct.setdefault(id(found), len(distinct))
        self.parts = list(self.wiring.parts)
        self.own = {
            name: Own(i, distinct[id(equations[name])], part, equations[name])
            for i, (name, part) in enumerate(self.wiring.parts.items())
            if name in equations
        }
        self.tables = {table_name(p): i for i, p in enumerate(self.wiring.tables)}
        self.programs: dict[Program, int] = {}
        for stretch in timetable.stretches():
            for program in stretch.entries:
                self.programs.setdefault(program, len(self.programs))

    @property
    def whole(self) -> bool:
        """Tell whether every component is one of ours: only then can it be in lanes."""
        return len(self.own) == len(self.parts)

    def text(self) -> str:
        """Return the source."""
        programs = [
            line
            for program, number in self.programs.items()
            for line in self._program(number, program)
        ]
        return "\n".join(
            [
                "#define _POSIX_C_SOURCE 199309L",
                '#include "engine.h"',
                "#if W == 1",
                '#include "kernel.c.h"',
                '#include "called.h"',
                "#endif",
                *self._models(),
                *self._faults(),
                *programs,
                *self._dispatch(),
                *self._adopted(),
                *(self._start() if self.whole else ()),
                '#include "run.h"',
                "",
            ]
        )

    # models

    def _models(self) -> Iterator[str]:
        count: dict[int, int] = {}
        for own in self.own.values():
            count[own.model] = count.get(own.model, 0) + 1
        done = set[int]()
        for own in self.own.values():
            if own.model not in done:
                done.add(own.model)
                yield from _model(own, count[own.model] > FEW)

    # programs

    def _program(self, number: int, program: Program) -> Iterator[str]:
        yield f"static int program_{number}(Engine *e, int64_t k, double t) {{"
        yield "    V *const z = e->vector;"
        yield "    (void)z, (void)k, (void)t;"
        for op in program:
            yield from (f"    {line}" for line in self._operation(op))
        yield "    return 1;"
        yield "}"

    def _operation(self, op: Op) -> Iterator[str]:
        if op.code == "fault":
            yield from self._fault_calls(op.target)
        elif op.code == "row":
            yield from self._row(op.target)
        elif op.target not in self.own:
            yield self._call(op)
        elif op.code in ("advance", "tick"):
            yield from self._step(self.own[op.target], op)
        elif op.code == "read":
            yield from self._read(self.own[op.target])
        elif op.code == "write":
            yield from _written(self.own[op.target])
        elif op.code == "hold":
            yield from _held(self.own[op.target])
        else:  # copy, release
            if op.code == "release":
                yield from _released(self.own[op.target])
            yield from self._copied(self.own[op.target].part.copies)

    def _call(self, op: Op) -> str:
        target = self.parts.index(op.target)
        code = f"{{{_CODE[op.code]}, {target}, {op.back}, {op.h.hex()}}}"
        return f"{{ const Op op = {code}; if (!called(e, &op, k, t)) return 0; }}"

    def _step(self, own: Own, op: Op) -> Iterator[str]:
        begins = f"seconds_of(e, k - {op.back})" if own.equations.delays else "0"
        step = f"{own.function}_step({own.instance}, {begins}, {op.h.hex()})"
        here = f"e->parts[{own.index}]"
        yield f"if (!{step})"
        yield f"    return stopped(e, {here}.failure, {own.index}, k);"
        yield f"if (!go_on(e, {here}.wrong, {own.index}, k))"
        yield "    return 0;"

    def _read(self, own: Own) -> Iterator[str]:
        yield from _values_read(own)
        y, end = own.equations["y"], own.equations["x"] + own.equations["n_x"]
        for place, reference, _ in _elements(own.part.read, own.part.raw):
            if not y <= reference < end:  # these the step has looked at
                bad = f"z[{place}] - z[{place}]"
                yield f"if (!go_on(e, {bad}, {own.index}, k))"
                yield "    return 0;"

    def _copied(self, copies: Iterable[Copy]) -> Iterator[str]:
        for copy in copies:
            yield f"z[{copy.sink}] = {_affine(f'z[{copy.source}]', copy.affine)};"

    def _row(self, table: str) -> Iterator[str]:
        number = self.tables[table]
        yield "#if W == 1"
        yield f"if (K) record(K, K->tables + {number}, t);"
        yield "else"
        yield "#endif"
        yield "{"
        columns = self._columns.get(table, ())
        yield f"    Rows *r = e->rows + {number};"
        yield f"    V *row = r->values + r->count++ * {len(columns)};"
        yield "    (void)row;"
        for i, place in enumerate(columns):
            yield f"    row[{i}] = z[{place}];"
        yield "}"

    def _dispatch(self) -> Iterator[str]:
        yield "static int carry_out_program(Engine *e, int n, int64_t k, double t) {"
        yield "    switch (n) {"
        for number in self.programs.values():
            yield f"    case {number}: return program_{number}(e, k, t);"
        yield "    default: return 0;"
        yield "    }"
        yield "}"

    # faults

    def _fault_calls(self, source: str) -> Iterator[str]:
        for i, faulty in enumerate(self.wiring.faulty):
            if not source or faulty.edge.source == source:
                yield f"fault_{i}(e, k, {int(bool(source))});"

    def _faults(self) -> Iterator[str]:
        tick = self.timetable.schedule.tick
        for i, faulty in enumerate(self.wiring.faulty):
            yield from _fault(i, faulty, tick)

    # initialisation

    def _adopted(self) -> Iterator[str]:
        """Write what follows initialisation, in lanes or by the FMUs themselves."""
        yield "static void settle(Engine *e) {"
        yield "    V *const z = e->vector;"
        yield "    (void)z;"
        for own in self.own.values():
            n = own.part.delayed
            yield f"    for (int i = 0; i < {own.part.component.latency * n}; i++)"
            yield (
                f"        e->parts[{own.index}].held[i] = "
                f"z[{own.part.raw} + i % {max(n, 1)}];"
            )
        yield from (f"    begin_fault_{i}(e);" for i in range(len(self.wiring.faulty)))
        yield "}"
        yield "EXPORTED void engine_adopt(Engine *e) {"
        for own in self.own.values():
            yield f"    {own.function}_derive(e->parts[{own.index}].values);"
            yield f"    {own.function}_begin({own.instance});"
        yield "    settle(e);"
        yield "}"

    def _start(self) -> Iterator[str]:
        order, edges = initial_order(self.wiring)
        opened = places_opened(self.wiring, edges)
        yield "static int sweep(Engine *e) {"
        yield "    V *const z = e->vector;"
        for name in order:
            own = self.own[name]
            kept = [c for c in own.part.copies if c.sink not in opened]
            lines = [*_written(own), f"{own.function}_refresh({own.instance});"]
            lines += [*_values_read(own), *_published(own), *self._copied(kept)]
            yield from (f"    {line}" for line in lines)
        yield "    return 1;"
        yield "}"
        yield "EXPORTED int engine_start(Engine *e) {"
        yield "    V *const z = e->vector;"
        for own in self.own.values():
            yield f"    {own.function}_derive(e->parts[{own.index}].values);"
            for place, reference, _ in _elements(own.part.inputs, own.part.first_input):
                yield f"    z[{place}] = {own.value(reference)};"
        yield from self._circles(opened)
        for own in self.own.values():
            yield from (f"    {line}" for line in _written(own))
            yield f"    {own.function}_refresh({own.instance});"
            yield f"    {own.function}_begin({own.instance});"
            y, x = own.equations["y"], own.equations["x"]
            count = x + own.equations["n_x"] - y
            found = f"wrong(&{own.value(y)}, {count})" if count else "(V)0.0"
            yield f"    if (!go_on(e, {found}, {own.index}, 0)) return 0;"
        for own in self.own.values():
            lines = [*_values_read(own), *_published(own)]
            lines += self._copied(own.part.copies)
            yield from (f"    {line}" for line in lines)
        yield "    settle(e);"
        yield "    return 1;"
        yield "}"

    def _circles(self, opened: Mapping[int, Copy]) -> Iterator[str]:
        """Write the sweeps: one, or until what was opened stands still in all lanes."""
        if not opened:
            yield "    sweep(e);"
            return
        n = len(opened)
        yield "    for (int round = 0, unlike = 1; unlike; round++) {"
        yield f"        V before[{n}];"
        for i, place in enumerate(opened):
            yield f"        before[{i}] = z[{place}];"
        yield "        sweep(e);"
        yield from (f"        {line}" for line in self._copied(opened.values()))
        yield "        V moved = (V)0.0;"
        for i, place in enumerate(opened):
            yield f"        moved = either(moved, unsettled(before[{i}], z[{place}]));"
        yield "        unlike = lanes_differ(moved, (V)0.0);"
        yield "        if (unlike && unlike < W) return stopped(e, APART, 0, 0);"
        yield (
            f"        if (unlike && round + 1 == {SUBSTITUTIONS}) "
            f"return stopped(e, UNSETTLED, 0, 0);"
        )
        yield "    }"


def _model(own: Own, often: bool) -> Iterator[str]:
    equations, name = own.equations, own.function
    for equation, statements in equations.functions.items():
        called = {"step": "tick"}.get(equation, equation)
        # carried out once: nothing is gained by optimising it, minutes may be lost
        how = "ONCE" if equation == "prepare" else "static inline"
        yield f"{how} void {name}_{called}(const V *const *arg, V *const *res) {{"
        yield "    (void)arg, (void)res;"
        yield from (f"    {line}" for line in statements)
        yield "}"
    numbers = {
        "CONTINUOUS": equations["continuous"],
        "SIZE": equations["size"],
        "U": equations["u"],
        "Y": equations["y"],
        "X": equations["x"],
        "DER_X": equations["der_x"],
        "T_S": equations["T_s"],
        "N_U": equations["n_u"],
        "N_X": equations["n_x"],
        "H_MAX": equations.numbers["h_max"].hex(),
        "N_DELAYS": len(equations.delays),
    }
    if equations.delays:
        pairs = ", ".join(f"{{{u}, {tau}}}" for u, tau, _ in equations.delays)
        numbers["DELAYS"] = f"{{ {pairs} }}"
    if "advance" in equations.functions:
        numbers["ADVANCE"] = ""
    defined: dict[str, object] = {"MODEL": name, **numbers}
    defined["STEP"] = "static NEVER_INLINE" if often else "static inline"
    yield from (f"#define {macro} {value}" for macro, value in defined.items())
    yield '#include "stepping.h"'
    yield from (f"#undef {macro}" for macro in defined)


def _elements(
    variables: Iterable[FmuVariable], first: int
) -> Iterator[tuple[int, int, bool]]:
    """Yield place, reference and whether it is Boolean, number by number."""
    place = first
    for variable in variables:
        for i in range(variable.size):
            yield place, variable.reference + i, variable.sort == "boolean"
            place += 1


def _values_read(own: Own) -> Iterator[str]:
    for place, reference, boolean in _elements(own.part.read, own.part.raw):
        value = own.value(reference)
        yield f"z[{place}] = {f'truth({value} != 0)' if boolean else value};"


def _written(own: Own) -> Iterator[str]:
    for place, reference, boolean in _elements(own.part.inputs, own.part.first_input):
        value = f"truth(z[{place}] != 0)" if boolean else f"z[{place}]"
        yield f"{own.value(reference)} = {value};"


def _published(own: Own) -> Iterator[str]:
    part = own.part
    if part.published != part.raw:
        size = f"{part.read_size} * sizeof(V)"
        yield f"memcpy(z + {part.published}, z + {part.raw}, {size});"


def _held(own: Own) -> Iterator[str]:
    part, here = own.part, f"e->parts[{own.index}]"
    n, latency = part.delayed, part.component.latency
    yield (f"memcpy({here}.held + {here}.head * {n}, z + {part.raw}, {n} * sizeof(V));")
    yield f"{here}.head = {here}.head + 1 == {latency} ? 0 : {here}.head + 1;"
    if rest := part.read_size - n:
        yield (
            f"memcpy(z + {part.published + n}, z + {part.raw + n}, {rest} * sizeof(V));"
        )


def _released(own: Own) -> Iterator[str]:
    n, here = own.part.delayed, f"e->parts[{own.index}]"
    source = f"{here}.held + {here}.head * {n}"
    yield f"memcpy(z + {own.part.published}, {source}, {n} * sizeof(V));"


def _affine(value: str, affine: Affine) -> str:
    if not affine.converts:
        return value
    return f"{_number(affine.gain)} * {value} + {_number(affine.offset)}"


def _number(value: float) -> str:
    return f"({value.hex()})"


def _fault(number: int, faulty: Faulty, tick: object) -> Iterator[str]:
    """Write the laws of ``orchestrator.master.faults`` for one place."""
    there, back = faulty.affine, faulty.affine.inverse()
    clean = _affine("f->clean", back) if there.converts else "f->clean"
    yield f"static void begin_fault_{number}(Engine *e) {{"
    yield f"    Faulty *f = e->faults + {number};"
    yield f"    f->clean = e->vector[{faulty.place}];"
    yield f"    for (int i = 0; i < {memory_of(faulty)}; i++)"
    yield f"        f->memory[i] = {clean};"
    yield "}"
    yield f"static void fault_{number}(Engine *e, int64_t k, int published) {{"
    yield f"    Faulty *f = e->faults + {number};"
    yield "    V value;"
    yield "    int any = 0, acts;"
    yield f"    if (published) f->clean = e->vector[{faulty.place}];"
    yield f"    value = {clean};"
    at = 0
    for fault in faulty.faults:
        start = ceil(fault.start / tick)  # type: ignore[operator]
        end = "" if fault.end is None else f" && k < {ceil(fault.end / tick)}"  # type: ignore[operator]
        yield f"    acts = k >= {start}{end};"
        yield "    any |= acts;"
        given = _number(fault.value)
        if fault.kind == "delay":
            n = fault.samples
            line = f"f->memory + {at}"
            if n:
                yield (
                    f"    if (published) memmove({line}, {line} + 1, {n} * sizeof(V));"
                )
            yield f"    f->memory[{at + n}] = value;"
            yield f"    if (acts) value = f->memory[{at}];"
            at += n + 1
        elif fault.kind == "stuck":
            yield f"    if (!acts) f->memory[{at}] = value;"
            yield f"    value = f->memory[{at}];"
            at += 1
        else:
            law = {
                "bias": f"value + {given}",
                "gain": f"{given} * value",
                "quantisation": f"{given} * v_floor(value / {given} + 0.5)",
                "override": f"(V){given}",
            }[fault.kind]
            yield f"    if (acts) value = {law};"
    yield "    if (!any) value = f->clean;"
    if there.converts:
        yield f"    else value = {_affine('value', there)};"
    yield f"    e->vector[{faulty.place}] = value;"
    yield "}"


def memory_of(faulty: Faulty) -> int:
    """Return how many numbers the faults of a place remember."""
    sizes = {"stuck": 1}
    return sum(
        f.samples + 1 if f.kind == "delay" else sizes.get(f.kind, 0)
        for f in faulty.faults
    )
