"""One instance of a model as NumPy runs it: its numbers and how they move.

The rules are those of the native adapters (``fmus/native/simulation.h``):
continuous models take n = max(1, ceil(h / h_max - 1e-6)) equal Runge-Kutta
substeps (or the model's ``advance``), cut where a delayed input changes;
outputs are then those at the new time with the inputs of the step.  Sampled
models run n ticks, by count, in a step within 1e-3 T_s of n periods, and in any
other step the ticks j for which it ends after start + j T_s, by the caller's clock
or by the sum of all steps, whichever is earlier (docs/decisions/0001).  Outside
stepping, outputs follow whatever is set.
"""

from typing import Any

import numpy as np

from fmus.layout import Block, Layout, layout
from fmus.model import Continuous, Model, Record, add, pack, unpack

WHOLE = 1e-3  # of a period: a step this near to n periods is n ticks
NEAR = 1e-9  # of a step: a delayed change this near to its end counts as there


class Line:
    """Exact dead time of one element of an input, piecewise constant in time."""

    def __init__(self, value: float) -> None:
        self.value = value
        self.changes: list[tuple[float, float]] = []

    def enter(self, time: float, value: float) -> None:
        """Keep the input's value from ``time`` (s) on, if it is a new one."""
        last = self.changes[-1][1] if self.changes else self.value
        if value != last:
            self.changes.append((time, value))

    def arrive(self, time: float) -> None:
        """Let everything entered up to ``time`` (s) arrive."""
        while self.changes and self.changes[0][0] <= time:
            self.value = self.changes.pop(0)[1]


class Simulation:
    """One instance: its numbers (laid out by ``fmus.layout``) and its motion."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.layout = _numeric_layout(model)
        starts = [v.start or (0.0,) * v.size for v in self.layout.variables]
        self.values = np.array([x for start in starts for x in start], dtype=float)
        self.start_time = 0.0
        self.tick = 0
        self.elapsed = self.excess = 0.0  # sum of all steps (s), and its rounding
        self.ahead = 0.0  # what the caller's clock is ahead of that (s)
        self.derived: tuple[Any, ...] | None = None
        self.outputs_stale = True
        self.lines: dict[int, Line] = {}
        self.begin()

    @property
    def delays(self) -> dict[int, int]:
        """Reference of each delayed element and of the parameter with its delay."""
        named = getattr(self.model, "delay", {})
        return {
            element: self.layout[dead_time].reference
            for name, dead_time in named.items()
            for _, element in self.layout[name].elements()
        }

    def begin(self) -> None:
        """Begin stepping: delayed inputs have always had their present value."""
        self.lines = {i: Line(float(self.values[i])) for i in self.delays}

    def put(self, reference: int, value: float, block: Block) -> None:
        """Set one value; what depends on it is computed when next needed."""
        self.values[reference] = value
        if block == "parameter":
            self.derived = None
        self.outputs_stale = True

    def refresh(self) -> None:
        """Compute outputs and derivatives if something was set before stepping."""
        if self.outputs_stale:
            self._publish(self._record("input", self.model.input))

    def step(self, t: float, h: float) -> None:
        """Step from t to t + h (s)."""
        if isinstance(self.model, Continuous):
            self._continuous(self.model, t, h)
        else:
            self._sampled(t, h)

    def snapshot(self) -> dict[str, Any]:
        """Return everything an FMU state must hold, as JSON knows it."""
        return {
            "values": self.values.tolist(),
            "start_time": self.start_time,
            "tick": self.tick,
            "elapsed": self.elapsed,
            "excess": self.excess,
            "ahead": self.ahead,
            "outputs_stale": self.outputs_stale,
            "lines": [[i, x.value, list(x.changes)] for i, x in self.lines.items()],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot of the same model."""
        self.values = np.array(state["values"], dtype=float)
        self.start_time, self.tick = state["start_time"], state["tick"]
        self.elapsed, self.excess = state["elapsed"], state["excess"]
        self.ahead = state["ahead"]
        self.derived, self.outputs_stale = None, state["outputs_stale"]
        for i, value, changes in state["lines"]:
            self.lines[i] = line = Line(value)
            line.changes = [(time, changed) for time, changed in changes]

    def not_finite(self) -> str | None:
        """Return the name of a state or output that is not finite."""
        for variable in self.layout.block("state") + self.layout.block("output"):
            for name, reference in variable.elements():
                if not np.isfinite(self.values[reference]):
                    return name
        return None

    def _record(self, block: Block, like: Record) -> Record:
        first = self.layout.offset[block]
        return unpack(like, self.values[first : first + self.layout.count[block]])

    def _store(self, block: Block, record: Record) -> None:
        first = self.layout.offset[block]
        self.values[first : first + self.layout.count[block]] = pack(record)

    def _arguments(self) -> tuple[Any, ...]:
        """Return the parameters and what is derived from them."""
        p = self._record("parameter", self.model.parameters)
        if self.derived is None:
            self.derived = derived(self.model, p)
        return (p, *self.derived)

    def _publish(self, u: Record) -> None:
        """Compute outputs and derivatives of the present states with inputs u."""
        model, x = self.model, self._record("state", self.model.state)
        p, *d = self._arguments()
        if isinstance(model, Continuous):
            self._store("derivative", model.derivative(x, u, p, *d))
            self._store("output", model.output(x, u, p, *d))
        else:
            self._store("output", model.step(x, u, p, float(model.period), *d)[1])
        self.outputs_stale = False

    def _continuous(self, model: Continuous, t: float, h: float) -> None:
        first, near = self.layout.offset["input"], NEAR * h
        u = self.values[first : first + self.layout.count["input"]].copy()
        for i, line in self.lines.items():
            line.enter(t, float(self.values[i]))
        begun = 0.0
        while begun < h:
            end = h
            for i, dead_time in self.delays.items():
                tau, line = float(self.values[dead_time]), self.lines[i]
                line.arrive(t + begun + near - tau)
                u[i - first] = line.value
                if line.changes and line.changes[0][0] + tau - t < min(end, h - near):
                    end = line.changes[0][0] + tau - t
            self._integrate(model, unpack(model.input, u), end - begun)
            begun = end
        self._publish(unpack(model.input, u))

    def _integrate(self, model: Continuous, u: Record, h: float) -> None:
        n = max(1, int(np.ceil(h / model.h_max - 1e-6)))
        x, (p, *d) = self._record("state", model.state), self._arguments()
        for _ in range(n):
            if model.advance is not None:
                x = model.advance(x, u, p, h / n, *d)
            else:
                x = runge_kutta(model.derivative, x, u, (p, *d), h / n)
        self._store("state", x)

    def _sampled(self, t: float, h: float) -> None:
        model = self.model
        assert not isinstance(model, Continuous)
        u, (p, *d) = self._record("input", model.input), self._arguments()
        num, den = model.period.as_integer_ratio()
        T_s = float(model.period)

        def tick() -> None:
            x, y = model.step(self._record("state", model.state), u, p, T_s, *d)
            self._store("state", x)
            self._store("output", y)
            self.tick += 1

        whole = int(np.floor(h / T_s + 0.5))
        if whole >= 1 and abs(h / T_s - whole) < WHOLE:
            self._add_time(whole * T_s)
            self.ahead += h - whole * T_s
            for _ in range(whole):
                tick()
            return
        self._add_time(h)
        end = min(t + h - self.ahead, self.start_time + self.elapsed) - 1e-6 * T_s
        while self.start_time + self.tick * num / den < end:
            tick()

    def _add_time(self, h: float) -> None:
        """Add a step (s) to the sum of all, by Kahan's rule."""
        part = h - self.excess
        total = self.elapsed + part
        self.excess = (total - self.elapsed) - part
        self.elapsed = total


def derived(model: Model, p: Record) -> tuple[Any, ...]:
    """Return what ``prepare`` computes, as the last arguments of the equations."""
    if model.prepare is None:
        return ()
    if isinstance(model, Continuous):
        return (model.prepare(p),)
    return (model.prepare(p, float(model.period)),)


def runge_kutta(f: Any, x: Record, u: Record, p: tuple[Any, ...], h: float) -> Record:
    """Return x after one classical Runge-Kutta step of h (s) with held inputs."""
    k1 = f(x, u, *p)
    k2 = f(add(x, [(h / 2, k1)]), u, *p)
    k3 = f(add(x, [(h / 2, k2)]), u, *p)
    k4 = f(add(x, [(h, k3)]), u, *p)
    return add(x, [(h / 6, k1), (h / 3, k2), (h / 3, k3), (h / 6, k4)])


def _numeric_layout(model: Model) -> Layout:
    x, u, p = model.state, model.input, model.parameters
    if isinstance(model, Continuous):
        return layout(model, model.output(x, u, p, *derived(model, p)))
    T_s = float(model.period)
    return layout(model, model.step(x, u, p, T_s, *derived(model, p))[1])
