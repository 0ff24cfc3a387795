"""A sampled component computed beside the substeps of a continuous one.

The substeps of a continuous component wait for each other: most of the time of the
processor is idle.  What a sampled component computes at the same instant without
being given anything before is written in pieces between them, in its own order, so
that every number keeps its bits; ``HERE`` (lanes.h) keeps the compiler from sorting
the pieces again.  docs/decisions/0025 has the measurements.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil

from orchestrator.master.fused.own import Own
from orchestrator.master.timetable import Program

LEAST, MOST = 4, 64  # stages: with fewer nothing is gained, more are not written out
PAIRS = 8  # functions written at most
PINNED = 3  # numbers of each piece that are computed where they stand
_ASSIGNED = re.compile(r"(a\d+) = ")


@dataclass(frozen=True)
class Pair:
    """A continuous component, the sampled one computed beside it, its step (s)."""

    continuous: Own
    sampled: Own
    h: float

    @property
    def function(self) -> str:
        c, s = self.continuous.index, self.sampled.index
        return f"step_{c}_beside_{s}_" + re.sub(r"\W", "_", self.h.hex())

    @property
    def call(self) -> str:
        c, s = self.continuous, self.sampled
        values = f"{c.instance}->values, {s.instance}->values"
        return f"{self.function}({c.instance}, {s.instance}, {values});"

    def text(self) -> Iterator[str]:
        """Return the function: stage, piece, stage, piece."""
        c, s = self.continuous.function, self.sampled.function
        equations = self.sampled.equations
        x, u, y = equations["x"], equations["u"], equations["y"]
        size, period = equations["size"], equations["T_s"]
        steps, each = _steps(self.continuous, self.h)
        tick = equations.functions["step"]
        declared = [line for line in tick if line.startswith("V ")]
        statements = [line for line in tick if not line.startswith("V ")]
        count = steps * each
        yield f"static NEVER_INLINE void {self.function}("
        yield "    Instance *c, Instance *s, V *restrict v, V *restrict w) {"
        inputs = f"v + {self.continuous.equations['u']}"
        yield f"    const double h = {self.h.hex()} / {steps};"
        yield f"    {c}_Stages r;"
        yield f"    V next[{equations['n_x']} + 1];"
        arguments = f"w + {x}, w + {u}, w, w + {size}, w + {period}"
        yield f"    const V *const arg[5] = {{{arguments}}};"
        yield f"    V *const res[2] = {{next, w + {y}}};"
        yield from (f"    {line}" for line in declared)
        yield "    (void)arg, (void)res;"
        for i in range(count):
            yield f"    {c}_stage(&r, v, {inputs}, h, {i % each});"
            begin, end = (j * len(statements) // count for j in (i, i + 1))
            piece = statements[begin:end]
            yield from (f"    {line}" for line in piece)
            yield f"    {c}_here(&r, {i % each});"
            yield from (f"    HERE({name});" for name in _last(piece))
        yield f"    {c}_ended(c, {inputs});"
        yield f"    {s}_ended(s, next);"
        yield "}"


def _last(piece: list[str]) -> list[str]:
    """Return the numbers that a piece computes last."""
    found = (_ASSIGNED.match(line) for line in reversed(piece))
    return list(dict.fromkeys(match[1] for match in found if match))[:PINNED]


def _steps(own: Own, h: float) -> tuple[int, int]:
    """Return into how many substeps a step falls, as stepping.h, and their stages."""
    substeps = int(max(1.0, ceil(h / own.equations.numbers["h_max"] - 1e-6)))
    return substeps, 1 if "advance" in own.equations.functions else 4


def pairs(
    program: Program, own: Mapping[str, Own], known: dict[str, Pair]
) -> dict[int, tuple[int, Pair]]:
    """Return, by the place of its ``advance``, each pair and the place of its ``tick``.

    Beside a continuous component is computed the longest sampled one that is given
    nothing in between.  What is new is put into ``known``, while there is room.
    """
    found: dict[int, tuple[int, Pair]] = {}
    taken = set[int]()
    for i, op in enumerate(program):
        if op.code != "advance" or op.target not in own:
            continue
        free = [j for j in _free(program, i) if program[j].target in own]
        free = [j for j in free if j not in taken]
        if not free or not _has_room(own[op.target], op.h):
            continue
        j = max(free, key=lambda j: _length(own[program[j].target]))
        pair = Pair(own[op.target], own[program[j].target], op.h)
        if pair.function in known or len(known) < PAIRS:
            known[pair.function] = pair
            taken.add(j)
            found[i] = j, pair
    return found


def _free(program: Program, i: int) -> Iterator[int]:
    """Yield the places of the ticks that may as well be carried out at place i."""
    touched = set[str]()
    for j, op in enumerate(program[i + 1 :], i + 1):
        if op.code == "tick" and op.target not in touched:
            yield j
        if op.code in ("write", "tick", "read"):
            touched.add(op.target)


def _has_room(own: Own, h: float) -> bool:
    substeps, each = _steps(own, h)
    return not own.equations.delays and LEAST <= substeps * each <= MOST


def _length(own: Own) -> int:
    return len(own.equations.functions["step"])
