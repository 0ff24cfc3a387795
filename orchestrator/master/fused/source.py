"""A timetable as C: one function per program, our models inlined as equations.

Every operation of a program becomes the statements it means, in its order, on
the places of the vector and the values of each component of ours; operations on
other FMUs stay calls of the kernel.  Parameters, start values, dead times and
rows are data: one source serves every run of its structure, and any number of
lanes W that it is compiled for.

    engine_start   initialisation in lanes (parts in order, circles by circle.h)
    engine_run     instants of a stretch, as ``kernel_run``
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from fmus.equations import Equations
from orchestrator.master.fused.beside import Pair, pairs
from orchestrator.master.fused.own import (
    Own,
    affine_text,
    elements,
    held,
    model,
    published,
    released,
    values_read,
    written,
)
from orchestrator.master.initialise import SUBSTITUTIONS, is_real, places_opened
from orchestrator.master.order import initial_order
from orchestrator.master.places import Copy
from orchestrator.master.timetable import Op, Program, Timetable, table_name
from orchestrator.native.library import CODES

OPENED = 64  # numbers of a circle in lanes at most
FEW = 4  # copies of one model that are inlined; more are calls of one function
_CODE = {name: i for i, name in enumerate(CODES)}
_CODE |= {"advance": _CODE["step"], "tick": _CODE["step"]}


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
        count = Counter(own.model for own in self.own.values())
        self._often = {model for model, n in count.items() if n > FEW}

    @property
    def whole(self) -> bool:
        """Tell whether every component is one of ours: only then can it be in lanes."""
        return len(self.own) == len(self.parts)

    def text(self) -> str:
        """Return the source."""
        few = {n: own for n, own in self.own.items() if own.model not in self._often}
        known: dict[str, Pair] = {}
        programs = [
            line
            for program, number in self.programs.items()
            for line in self._program(number, program, pairs(program, few, known))
        ]
        return "\n".join(
            [
                "#ifdef KERNEL",
                "#define _POSIX_C_SOURCE 199309L",
                "#endif",
                '#include "engine.h"',
                "#ifdef KERNEL",
                '#include "kernel.c.h"',
                '#include "called.h"',
                "#endif",
                *self._models(),
                *(line for pair in known.values() for line in pair.text()),
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
        done = set[int]()
        for own in self.own.values():
            if own.model not in done:
                done.add(own.model)
                yield from model(own, own.model in self._often)

    # programs

    def _program(
        self, number: int, program: Program, found: Mapping[int, tuple[int, Pair]]
    ) -> Iterator[str]:
        yield f"static int program_{number}(Engine *e, int64_t k, double t) {{"
        yield "    V *const z = e->vector;"
        yield "    (void)z, (void)k, (void)t;"
        beside = {tick: pair.sampled for tick, pair in found.values()}
        for i, op in enumerate(program):
            if i in found:
                pair = found[i][1]
                lines = [pair.call, *self._went_on(pair.continuous)]
            elif i in beside:
                lines = list(self._went_on(beside[i]))
            else:
                lines = list(self._operation(op))
            yield from (f"    {line}" for line in lines)
        yield "    return 1;"
        yield "}"

    def _operation(self, op: Op) -> Iterator[str]:
        if op.code == "fault":
            yield from self._fault_calls(op.target)
        elif op.code == "row":
            yield from self._row(op.target)
        elif op.code == "inject":
            yield self._injection(int(op.target))
        elif op.target not in self.own:
            yield self._call(op)
        elif op.code in ("advance", "tick"):
            yield from self._step(self.own[op.target], op)
        elif op.code == "read":
            yield from self._read(self.own[op.target])
        elif op.code == "write":
            yield from written(self.own[op.target])
        elif op.code == "hold":
            yield from held(self.own[op.target])
        else:  # copy, release
            if op.code == "release":
                yield from released(self.own[op.target])
            yield from self._copied(self.own[op.target].part.copies)

    def _injection(self, i: int) -> str:
        injected = self.wiring.injected[i]
        sink = f"z[{injected.place}]"
        before = sink if injected.driven else f"e->injections[{i}].began"
        return f"{sink} = {before} + injected_at(e->injections + {i}, k);"

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
        yield from self._went_on(own)

    def _went_on(self, own: Own) -> Iterator[str]:
        yield f"if (!go_on(e, e->parts[{own.index}].wrong, {own.index}, k))"
        yield "    return 0;"

    def _read(self, own: Own) -> Iterator[str]:
        yield from values_read(own)
        y, end = own.equations["y"], own.equations["x"] + own.equations["n_x"]
        for place, reference, _ in elements(own.part.read, own.part.raw):
            if not y <= reference < end:  # these the step has looked at
                bad = f"z[{place}] - z[{place}]"
                yield f"if (!go_on(e, {bad}, {own.index}, k))"
                yield "    return 0;"

    def _copied(self, copies: Iterable[Copy]) -> Iterator[str]:
        for copy in copies:
            yield f"z[{copy.sink}] = {affine_text(f'z[{copy.source}]', copy.affine)};"

    def _row(self, table: str) -> Iterator[str]:
        number = self.tables[table]
        yield "#ifdef KERNEL"
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
                yield f"faulty_renew(e->faults + {i}, k, {int(bool(source))});"

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
        for i, injected in enumerate(self.wiring.injected):
            yield f"    e->injections[{i}].began = z[{injected.place}];"
        yield f"    for (int i = 0; i < {len(self.wiring.faulty)}; i++)"
        yield "        faulty_begin(e->faults + i);"
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
        if opened:
            yield f"enum {{ CIRCLE = {len(opened)}, SUBSTITUTIONS = {SUBSTITUTIONS} }};"
            yield '#include "circle.h"'
        yield "/* NaN in the lanes where an input is given what is not finite */"
        yield "static V sweep(Engine *e) {"
        yield "    V *const z = e->vector, bad = (V)0.0;"
        yield "    (void)z;"
        for name in order:
            copies = self.wiring.parts[name].copies
            kept = [c for c in copies if c.sink not in opened]
            lines = [*self._evaluated(name), *self._copied(kept)]
            lines += [f"bad += z[{c.sink}] - z[{c.sink}];" for c in kept]
            yield from (f"    {line}" for line in lines)
        yield "    return bad;"
        yield "}"
        yield "EXPORTED int engine_start(Engine *e) {"
        yield "    V *const z = e->vector;"
        yield "    (void)z;"
        yield "    e->failure = FINE;"
        for name in self.parts:
            yield from (f"    {line}" for line in self._entered(name))
        yield from self._circles(opened)
        for name in self.parts:
            yield from (f"    {line}" for line in self._left(name))
        for name in self.parts:
            lines = [*self._told(name), *self._copied(self.wiring.parts[name].copies)]
            yield from (f"    {line}" for line in lines)
        yield "    settle(e);"
        yield "    return 1;"
        yield "}"

    # what a component does there

    def _entered(self, name: str) -> Iterator[str]:
        """Write how it is brought into initialisation, and what its inputs are."""
        own = self.own[name]
        yield f"{own.function}_derive(e->parts[{own.index}].values);"
        for place, reference, _ in elements(own.part.inputs, own.part.first_input):
            yield f"z[{place}] = {own.value(reference)};"

    def _evaluated(self, name: str) -> Iterator[str]:
        """Write how its inputs become outputs while it is there."""
        own = self.own[name]
        yield from written(own)
        yield f"{own.function}_refresh({own.instance});"
        yield from self._told(name)

    def _left(self, name: str) -> Iterator[str]:
        """Write how it leaves initialisation."""
        own = self.own[name]
        yield from written(own)
        yield f"{own.function}_refresh({own.instance});"
        yield f"{own.function}_begin({own.instance});"
        y, x = own.equations["y"], own.equations["x"]
        count = x + own.equations["n_x"] - y
        found = f"wrong(&{own.value(y)}, {count})" if count else "(V)0.0"
        yield f"if (!go_on(e, {found}, {own.index}, 0)) return 0;"

    def _told(self, name: str) -> Iterator[str]:
        """Write how its outputs are read and published."""
        own = self.own[name]
        yield from values_read(own)
        yield from published(own)

    def _circles(self, opened: Mapping[int, Copy]) -> Iterator[str]:
        """Write the sweeps: one, or until every lane has found its inputs."""
        if not opened:
            yield "    sweep(e);"
            yield "    if (e->failure) return 0;"
            return
        if len(opened) > OPENED:
            yield "    return stopped(e, UNSETTLED, 0, 0);"
            return
        yield "    V asked[CIRCLE], given[CIRCLE];"
        yield "    Circle found[W];"
        for i, place in enumerate(opened):
            yield f"    asked[{i}] = z[{place}];"
        yield "    circles_begin(found, asked);"
        yield "    for (int going = 1; going;) {"
        for i, place in enumerate(opened):
            yield f"        z[{place}] = asked[{i}];"
        yield "        V bad = sweep(e);"
        for i, copy in enumerate(opened.values()):
            value = affine_text(f"z[{copy.source}]", copy.affine)
            yield f"        given[{i}] = {value};"
        real = int(all(is_real(self.wiring, place) for place in opened))
        yield f"        going = circles_next(found, asked, given, bad, {real});"
        yield "    }"
        yield "    if (circles_failed(found)) return stopped(e, UNSETTLED, 0, 0);"
        yield "    circles_found(found, asked);"
        yield "    e->failure = FINE; /* what was refused on the way */"
        for i, place in enumerate(opened):
            yield f"    z[{place}] = asked[{i}];"
