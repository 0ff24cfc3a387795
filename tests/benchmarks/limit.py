"""The limit: the C program that somebody would write by hand for one system.

Straight-line calls with every reference and place a constant; it checks every
status and every output, and writes the rows recorded to a file, as the kernel
does.  It knows one rate, FMI 2.0 and doubles.
"""

from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path

from orchestrator.fmu.description import FmuVariable
from orchestrator.master.layout import Copy, Part
from orchestrator.master.order import initial_order
from orchestrator.master.timetable import Op, Program, Timetable

HEAD = Path(__file__).with_name("limit_head.c")


def limit_source(timetable: Timetable, folders: Mapping[Path, Path]) -> str:
    """Return the program; ``folders`` says where each FMU was unpacked."""
    programs: dict[str, Program] = {}
    for stretch in timetable.stretches():
        for offset, program in zip(stretch.offsets, stretch.entries, strict=True):
            k = stretch.first + offset
            last = k == timetable.schedule.stop
            programs["first" if k == 0 else "last" if last else "steady"] = program
    wiring = timetable.wiring
    tick = timetable.schedule.tick
    columns = [c for table in wiring.tables.values() for c in table]
    lines = [
        HEAD.read_text(),
        f"enum {{ N = {timetable.schedule.stop}, COLUMNS = {len(columns)} }};",
        f"static double v[{wiring.size}], times[4096], rows[COLUMNS][4096];",
        f"#define T(k) ((double)((k) * {tick.numerator}LL) / {tick.denominator}.0)",
    ]
    fmus = {fmu: f"f{i}" for i, fmu in enumerate(folders)}
    lines += [f"static Fmu {name};" for name in fmus.values()]
    for i, part in enumerate(wiring.parts.values()):
        lines += _declarations(i, part)
    number = {name: i for i, name in enumerate(wiring.parts)}
    for name, program in programs.items():
        lines.append(f"static int {name}(long long k) {{")
        for op in program:
            lines += _op(op, number, wiring.parts, fmus, [c.index for c in columns])
        lines.append("    return 1;\n}")
    lines.append("static void start(void) {")
    for fmu, folder in folders.items():
        identifier = next(
            p.fmu.model_identifier for p in wiring.parts.values() if p.fmu.path == fmu
        )
        library = folder / "binaries" / "linux64" / f"{identifier}.so"
        lines.append(f'    load(&{fmus[fmu]}, "{library}");')
    parts = [(number[n], p, fmus[p.fmu.path]) for n, p in wiring.parts.items()]
    for i, part, fmu in parts:
        lines += _instantiate(i, part, fmu, folders[part.fmu.path])
    for name in initial_order(wiring)[0]:
        lines += _evaluate(number[name], wiring.parts[name])
    for i, part, fmu in parts:
        lines += _set(i, part)
        lines.append(f"    CHECK({fmu}.exit(c{i}));")
    for i, part, _ in parts:
        lines += _get(i, part) + _copy(part.copies)
    for i, part, _ in parts:
        if part.component.latency:
            lines.append(
                f"    memcpy(line{i}, v + {part.raw}, {part.delayed} * sizeof *v);"
            )
    return "\n".join([*lines, "}", Path(HEAD.with_name("limit_main.c")).read_text()])


def _references(variables: tuple[FmuVariable, ...]) -> str:
    return ", ".join(str(v.reference) for v in variables) or "0"


def _declarations(i: int, part: Part) -> Iterator[str]:
    assert part.component.latency < 2
    yield f"static void *c{i};"
    yield f"static const unsigned in{i}[] = {{{_references(part.inputs)}}};"
    yield f"static const unsigned out{i}[] = {{{_references(part.read)}}};"
    yield f"static double line{i}[{max(1, part.delayed)}];"


def _instantiate(i: int, part: Part, fmu: str, folder: Path) -> Iterator[str]:
    text = f'"{part.fmu.token}", "file://{folder}/resources"'
    yield f'    c{i} = {fmu}.instantiate("{part.name}", 1, {text}, &callbacks, 0, 0);'
    for variable, values in part.start:
        for offset, value in enumerate(values):
            kind = "int" if variable.fmi_type == "Boolean" else "double"
            setter = "set_boolean" if kind == "int" else "set"
            number = int(value) if kind == "int" else float(value).hex()
            yield f"    {{ unsigned r = {variable.reference + offset};"
            yield f"      {kind} x = {number};"
            yield f"      CHECK({fmu}.{setter}(c{i}, &r, 1, &x)); }}"
    yield f"    CHECK({fmu}.setup(c{i}, 0, 0, 0, 0, 0));"
    yield f"    CHECK({fmu}.enter(c{i}));"
    yield f"#define F{i} {fmu}"
    if part.inputs:
        n = part.input_size
        yield f"    CHECK({fmu}.get(c{i}, in{i}, {n}, v + {part.first_input}));"


def _set(i: int, part: Part) -> list[str]:
    n = part.input_size
    place = f"in{i}, {n}, v + {part.first_input}"
    return [f"    CHECK(F{i}.set(c{i}, {place}));"] if n else []


def _get(i: int, part: Part) -> list[str]:
    n = part.read_size
    if not n:
        return []
    lines = [f"    CHECK(F{i}.get(c{i}, out{i}, {n}, v + {part.raw}));"]
    if part.raw != part.published:
        size = f"{n} * sizeof *v"
        lines.append(f"    memcpy(v + {part.published}, v + {part.raw}, {size});")
    return lines


def _evaluate(i: int, part: Part) -> list[str]:
    return _set(i, part) + _get(i, part) + _copy(part.copies)


def _copy(copies: tuple[Copy, ...]) -> list[str]:
    return [
        f"    v[{c.sink}] = {c.affine.gain.hex()} * v[{c.source}] + "
        f"{c.affine.offset.hex()};"
        if c.affine.converts
        else f"    v[{c.sink}] = v[{c.source}];"
        for c in copies
    ]


def _op(
    op: Op,
    number: Mapping[str, int],
    parts: Mapping[str, Part],
    fmus: Mapping[Path, str],
    columns: list[int],
) -> Iterator[str]:
    if op.code == "row":
        yield "    times[filled] = T(k);"
        yield from (f"    rows[{c}][filled] = v[{i}];" for c, i in enumerate(columns))
        yield "    if (++filled == 4096) flush(times, rows[0], COLUMNS);"
        return
    i, part = number[op.target], parts[op.target]
    fmu = fmus[part.fmu.path]
    if op.code in ("advance", "tick"):
        yield f"    CHECK({fmu}.step(c{i}, T(k - {op.back}), {op.h.hex()}, 1));"
    elif op.code == "write":
        n = part.input_size
        yield f"    CHECK({fmu}.set(c{i}, in{i}, {n}, v + {part.first_input}));"
    elif op.code == "read":
        n = part.read_size
        yield f"    CHECK({fmu}.get(c{i}, out{i}, {n}, v + {part.raw}));"
        checks = [f"isfinite(v[{part.raw + j}])" for j in range(n)]
        yield f"    if (!({' && '.join(checks)})) return 0;"
    elif op.code == "copy":
        yield from _copy(part.copies)
    elif op.code == "release":
        size = f"{part.delayed} * sizeof *v"
        yield f"    memcpy(v + {part.published}, line{i}, {size});"
        yield from _copy(part.copies)
    else:
        size = f"{part.delayed} * sizeof *v"
        yield f"    memcpy(line{i}, v + {part.raw}, {size});"
        rest = range(part.delayed, part.read_size)
        yield from chain(
            f"    v[{part.published + j}] = v[{part.raw + j}];" for j in rest
        )
