"""The C of faults on connections: the laws of ``orchestrator.master.faults``."""

from collections.abc import Iterator
from fractions import Fraction
from math import ceil

from orchestrator.master.fused.own import affine_text, number_text
from orchestrator.master.layout import Faulty


def fault_text(number: int, faulty: Faulty, tick: Fraction) -> Iterator[str]:
    """Write the laws of ``orchestrator.master.faults`` for one place."""
    there, back = faulty.affine, faulty.affine.inverse()
    clean = affine_text("f->clean", back) if there.converts else "f->clean"
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
        start = ceil(fault.start / tick)
        end = "" if fault.end is None else f" && k < {ceil(fault.end / tick)}"
        yield f"    acts = k >= {start}{end};"
        yield "    any |= acts;"
        given = number_text(fault.value)
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
        yield f"    else value = {affine_text('value', there)};"
    yield f"    e->vector[{faulty.place}] = value;"
    yield "}"


def memory_of(faulty: Faulty) -> int:
    """Return how many numbers the faults of a place remember."""
    sizes = {"stuck": 1}
    return sum(
        f.samples + 1 if f.kind == "delay" else sizes.get(f.kind, 0)
        for f in faulty.faults
    )
