"""A hyperperiod of the timetable, carried out on linearised parts.

Every number that is remembered from one hyperperiod to the next is an unknown, and so
is each that is injected within it.  Signals are rows (n, unknowns); what is left at
the end, and what is observed whenever something is injected, are then

    z x = A x + B d,   y = C x + D d,   z = exp(jω whole)

with x (those that matter), d (excited, injections) and y (injections, observed).  The
fundamental of y over d is the response of a line.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError
from orchestrator.master.layout import Part
from orchestrator.master.timetable import Op, Timetable
from orchestrator.response.bench import Bench
from orchestrator.response.linear import Line, Linear
from orchestrator.response.modes import Growth, growth

Real = NDArray[np.float64]
Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]

MOST = 4000  # unknowns


@dataclass
class _Memory:
    """What is remembered: the vector, and of each part states, outputs, held inputs,
    and what its latency holds back."""

    vector: Real
    x: dict[str, Real] = field(default_factory=dict)
    y: dict[str, Real] = field(default_factory=dict)
    lines: dict[str, Line] = field(default_factory=dict)
    rings: dict[str, list[Real]] = field(default_factory=dict)

    def blocks(self) -> list[Real]:
        """Return all of it, in one order."""
        return [
            self.vector,
            *self.x.values(),
            *self.y.values(),
            *(u for line in self.lines.values() for _, u in line.held),
            *(held for ring in self.rings.values() for held in ring),
        ]

    def made_of(self, rows: Real) -> "_Memory":
        """Return the same with other numbers, ``rows`` (all, K)."""
        sizes = [len(block) for block in self.blocks()]
        taken = iter(np.split(rows, np.cumsum(sizes)[:-1]))
        return _Memory(
            next(taken).copy(),
            {name: next(taken) for name in self.x},
            {name: next(taken) for name in self.y},
            {
                name: Line([(t, next(taken)) for t, _ in line.held])
                for name, line in self.lines.items()
            },
            {name: [next(taken) for _ in ring] for name, ring in self.rings.items()},
        )


class Window:
    """Linearised ``parts`` of a timetable whose system injects ones at all breaks.

    After ``settled`` hyperperiods all that is remembered has its place.
    """

    def __init__(
        self,
        at: Bench,
        timetable: Timetable,
        parts: Mapping[str, Linear],
        settled: int,
    ) -> None:
        self._settled = settled
        self._bench, self._timetable, self._parts = at, timetable, parts
        self._tick = timetable.schedule.tick
        self._whole = int(at.rates.whole / self._tick)
        self._T = int(at.rates.T / self._tick)
        wiring = timetable.wiring
        self._first, _ = timetable.publications(wiring.injected[0])
        sinks = {sink: j for j, b in enumerate(at.breaks) for sink, _ in b.sinks}
        self._of = [sinks[name] for name in wiring.system.injections]
        columns = [c for table in wiring.tables.values() for c in table]
        self._seen = [
            next(c for c in columns if c.name == name) for name, _ in at.observed
        ]
        self._x, self._y = self._matrices()

    def response(self, hz: Real) -> Complex:
        """Return y/d (lines, observed, excited) at lines (Hz).

        Raises:
            ResponseError: a line is an eigenvalue of an undamped mode.
        """
        n, m = len(self._x), len(self._bench.breaks)
        P = self._whole // self._T
        A, B = self._x[:, :n], self._x[:, n:].reshape(n, m, P)
        C, D = self._y[:, :, :n], self._y[:, :, n:].reshape(P, -1, m, P)
        T = float(self._bench.rates.T)
        found = []
        for f in hz:
            turns = np.exp(2j * np.pi * f * T * np.arange(P))
            z = np.exp(2j * np.pi * f * T * P)
            try:
                x = np.linalg.solve(z * np.eye(n) - A, B @ turns)
            except np.linalg.LinAlgError:
                raise ResponseError(
                    f"no linearised equations beside it: they oscillate undamped at "
                    f"{f:g} Hz"
                ) from None
            y = C @ x + D @ turns
            found.append(np.tensordot(turns.conj(), y, 1) / P)
        return np.array(found)

    def growth(self) -> Growth | None:
        """Return the mode that grows fastest, None if none does."""
        return growth(self._x[:, : len(self._x)], float(self._bench.rates.whole))

    def linked(self) -> Bools:
        """Return whether anything leads to what is observed, (observed, breaks)."""
        n, m = len(self._x), len(self._bench.breaks)
        P = self._whole // self._T
        A, C = self._x[:, :n] != 0, np.any(self._y[:, :, :n] != 0, axis=0)
        B = np.any(self._x[:, n:].reshape(n, m, P) != 0, axis=2)
        D = np.any(self._y[:, :, n:].reshape(P, -1, m, P) != 0, axis=(0, 3))
        while not np.array_equal(B, more := B | (A @ B)):
            B = more
        found: Bools = D | (C @ B)
        return found

    def _matrices(self) -> tuple[Real, Real]:
        """Return x and y of the contract above, over what matters of x and over d."""
        wiring = self._timetable.wiring
        memory = _Memory(np.zeros((wiring.size, 1)))
        for name, part in self._parts.items():
            n, m, p = part.sizes
            memory.x[name], memory.y[name] = np.zeros((n, 1)), np.zeros((p, 1))
            memory.lines[name] = Line([(Fraction(-1), np.zeros((m, 1)))])
        for name, of in wiring.parts.items():
            if of.component.latency:
                empty = np.zeros((of.delayed, 1))
                memory.rings[name] = [empty] * of.component.latency
        begin = self._first + self._settled * self._whole
        end = begin + self._whole
        P, m = self._whole // self._T, len(self._bench.breaks)
        seen, N = [], 0
        for k, program in self._timetable.instants():
            if k == begin:
                N = sum(map(len, memory.blocks()))
                if N + m * P > MOST:
                    raise ResponseError(
                        f"no linearised equations beside it: the rates repeat after "
                        f"{float(self._bench.rates.whole):g} s only, which makes "
                        f"{N + m * P} unknowns"
                    )
                memory = memory.made_of(np.eye(N, N + m * P))
            if k >= end:
                break
            for op in program:
                self._carry_out(op, k, memory, N if k >= begin else None)
            if k >= begin and (k - begin) % self._T == 0:
                rows = [c.affine.gain * memory.vector[c.index] for c in self._seen]
                seen.append(np.array(rows))
        after = np.concatenate(memory.blocks())
        return _what_matters(after, np.array(seen))

    def _carry_out(self, op: Op, k: int, memory: _Memory, unknown: int | None) -> None:
        vector = memory.vector
        if op.code in ("row", "fault"):
            return
        if op.code == "inject":
            injected = self._timetable.wiring.injected[int(op.target)]
            if not injected.driven:
                vector[injected.place] = 0
            if unknown is not None:
                P = self._whole // self._T
                i = (k - self._first) // self._T % P
                at = unknown + self._of[int(op.target)] * P + i
                vector[injected.place, at] += injected.values[0]
            return
        part = self._timetable.wiring.parts[op.target]
        if op.code == "copy":
            _copy(part, vector)
        elif op.code == "release":
            vector[part.published : part.published + part.delayed] = memory.rings[
                part.name
            ][0]
            _copy(part, vector)
        elif op.code == "hold":
            raw, n = part.raw, part.delayed
            rest = slice(part.published + n, part.published + part.read_size)
            vector[rest] = vector[raw + n : raw + part.read_size]
            ring = memory.rings[part.name]
            memory.rings[part.name] = [*ring[1:], vector[raw : raw + n].copy()]
        elif part.name in self._parts:
            self._step(op, k, self._parts[part.name], memory)

    def _step(self, op: Op, k: int, linear: Linear, memory: _Memory) -> None:
        part, now, at = linear.part, k * self._tick, linear.at
        line, vector = memory.lines[part.name], memory.vector
        x, y = memory.x[part.name], memory.y[part.name]
        if op.code == "write":
            u = np.zeros((at.B.shape[1], vector.shape[1]))
            first = part.first_input
            u[linear.inputs] = vector[first : first + part.input_size]
            line.hold(now, u)
            line.forget(now - linear.late if linear.continuous else now)
        elif op.code == "advance":
            x = linear.step(x, line, now - op.back * self._tick, now)
            y = at.C @ x + at.D @ linear.arriving(line, now)
        elif op.code == "tick":
            u = line.held[-1][1]
            x, y = at.A @ x + at.B @ u, at.C @ x + at.D @ u
        elif op.code == "read":
            vector[part.raw : part.raw + part.read_size] = linear.rows(x, y)
        memory.x[part.name], memory.y[part.name] = x, y


def _copy(part: Part, vector: Real) -> None:
    for c in part.copies:
        vector[c.sink] = c.affine.gain * vector[c.source]


def _what_matters(after: Real, seen: Real) -> tuple[Real, Real]:
    """Return the same without the unknowns from which nothing that is seen follows."""
    N = len(after)
    matters = np.any(seen[:, :, :N] != 0, axis=(0, 1))
    while True:
        more = matters | np.any(after[matters, :N] != 0, axis=0)
        if np.array_equal(more, matters):
            break
        matters = more
    kept = np.append(matters, np.ones(after.shape[1] - N, bool))
    return after[matters][:, kept], seen[:, :, kept]
