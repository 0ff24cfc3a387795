"""One component's traced equations, linearised, as the master steps them.

Signals are rows (n, K): how n numbers depend on K unknowns.  A continuous model holds
its inputs over a step, which is exact (zero-order hold); dead time splits a step where
an older input arrives.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from fmus.jacobian import Jacobians, jacobians
from fmus.layout import Block, layout
from fmus.model import Continuous, Model
from fmus.trace import trace
from orchestrator.fmu.description import FmuVariable
from orchestrator.master.layout import Part

Real = NDArray[np.float64]

TINY = Fraction(1, 10**9)  # of a step


class Linear:
    """A part of a system whose FMU was made of ``model``, about a point.

    ``point`` are states and inputs there, by value reference.
    """

    def __init__(self, part: Part, model: Model, point: Mapping[int, float]) -> None:
        traced = trace(model)
        self.part, self.model = part, model
        self._layout = layout(model, traced.output_like)
        values = np.zeros(self._layout.size)
        for variable in self._layout.variables:
            first, start = variable.reference, variable.start
            values[first : first + len(start)] = start
        for written, given in part.start:
            at = slice(written.reference, written.reference + len(given))
            values[at] = [float(value) for value in given]
        for reference, value in point.items():
            values[reference] = value
        blocks: tuple[Block, ...] = ("parameter", "state", "input")
        p, x, u = (self._block(values, block) for block in blocks)
        T_s = 0.0 if self.continuous else float(part.component.period)
        self.at: Jacobians = jacobians(
            model, p, x, u, T_s, traced=traced, without_steps=True
        )
        self._delays = self._dead_times(values)
        self._held: dict[Fraction, tuple[Real, Real]] = {}

    @property
    def continuous(self) -> bool:
        return isinstance(self.model, Continuous)

    @property
    def sizes(self) -> tuple[int, int, int]:
        """How many states, inputs and outputs there are."""
        return len(self.at.A), self.at.B.shape[1], len(self.at.C)

    @cached_property
    def inputs(self) -> list[int]:
        """The model's inputs that the part's connected inputs are, in their order."""
        first = self._layout.offset["input"]
        return [r - first for v in self.part.inputs for r in _references(v)]

    def rows(self, x: Real, y: Real) -> Real:
        """Return what is read (n, K) of states and outputs; of all else zeros."""
        found = []
        for variable in self.part.read:
            for reference in _references(variable):
                row = np.zeros(x.shape[1])
                blocks: tuple[tuple[Block, Real], ...] = ("state", x), ("output", y)
                for block, rows in blocks:
                    at = reference - self._layout.offset[block]
                    if 0 <= at < self._layout.count[block]:
                        row = rows[at]
                found.append(row)
        return np.array(found).reshape(len(found), x.shape[1])

    def step(self, x: Real, line: "Line", begin: Fraction, end: Fraction) -> Real:
        """Return states (n, K) at the end of a step with what is held in ``line``."""
        times = {begin, end}
        for _, tau in self._delays:
            times |= {t + tau for t, _ in line.held if begin < t + tau < end}
        ordered = sorted(times)
        for one, other in pairwise(ordered):
            if other - one > TINY * (end - begin):
                A, B = self._over(other - one)
                x = A @ x + B @ self.arriving(line, one)
        return x

    def arriving(self, line: "Line", t: Fraction) -> Real:
        """Return the inputs (m, K) as they act from t on, late ones included."""
        u = line.held[-1][1].copy()
        for i, tau in self._delays:
            u[i] = line.at(t - tau)[i]
        return u

    @property
    def late(self) -> Fraction:
        """The longest dead time (s)."""
        return max((tau for _, tau in self._delays), default=Fraction(0))

    def _over(self, h: Fraction) -> tuple[Real, Real]:
        if h not in self._held:
            n, m, _ = self.sizes
            whole = np.zeros((n + m, n + m))
            whole[:n, :n], whole[:n, n:] = self.at.A, self.at.B
            passed = expm(whole * float(h))
            self._held[h] = passed[:n, :n], passed[:n, n:]
        return self._held[h]

    def _block(self, values: Real, block: Block) -> Real:
        first = self._layout.offset[block]
        count = self._layout.count[block]
        return values[first : first + count]

    def _dead_times(self, values: Real) -> list[tuple[int, Fraction]]:
        model, found = self.model, []
        if isinstance(model, Continuous):
            for name, tau in model.delay.items():
                delayed, by = self._layout[name], self._layout[tau]
                for i in range(delayed.size):
                    late = values[by.reference + (i if by.size > 1 else 0)]
                    at = delayed.reference + i - self._layout.offset["input"]
                    found.append((at, Fraction(repr(float(late)))))
        return found


class Line:
    """What a component's inputs were held at, each from a time (s) on."""

    def __init__(self, held: list[tuple[Fraction, Real]]) -> None:
        self.held = held

    def hold(self, t: Fraction, u: Real) -> None:
        """Hold inputs (m, K) from t on."""
        self.held = [(s, v) for s, v in self.held if s < t] + [(t, u)]

    def forget(self, before: Fraction) -> None:
        """Drop what does not act any more at a time."""
        while len(self.held) > 1 and self.held[1][0] <= before:
            del self.held[0]

    def at(self, t: Fraction) -> Real:
        """Return what was held at a time, before all that is known the first."""
        return next((v for s, v in reversed(self.held) if s <= t), self.held[0][1])


def _references(variable: FmuVariable) -> range:
    return range(variable.reference, variable.reference + variable.size)
