"""A model with its equations in NumPy and CasADi, a trajectory, and its FMU driven.

The NumPy equations are the reference; ``Subject`` integrates them itself.
"""

from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy import read_model_description

from fmus.layout import layout
from fmus.model import Continuous, leaves, pack, unpack
from fmus.trace import trace

STEPS = 1000


def derived(model, p):
    if model.prepare is None:
        return ()
    if isinstance(model, Continuous):
        return (model.prepare(p),)
    return (model.prepare(p, float(model.period)),)


class Subject:
    """A model with its traced equations, layout and a plausible trajectory."""

    def __init__(self, module: str) -> None:
        self.module: ModuleType = import_module(module)
        self.model = self.module.model
        self.traced = trace(self.model)
        self.layout = layout(self.model, self.traced.output_like)
        self.continuous = isinstance(self.model, Continuous)
        self.late = dict.fromkeys(range(self.layout.count["input"]), 0)
        if not self.continuous:
            self.h = float(self.model.period)
        elif self.model.delay:
            self.h = self._delays()
        else:
            self.h = 5 * self.model.h_max

    def _delays(self) -> float:
        """Note by how many steps inputs are late; return the step they fit in."""
        starts = {v.name: v.start for v in self.layout.block("parameter")}
        tau = {name: starts[by][0] for name, by in self.model.delay.items()}
        shortest = min(tau.values())
        h = shortest / max(1, round(shortest / (5 * self.model.h_max)))
        for name, dead_time in tau.items():
            assert dead_time / h == pytest.approx(round(dead_time / h))
            for _, reference in self.layout[name].elements():
                late = reference - self.layout.offset["input"]
                self.late[late] = round(dead_time / h)
        return h

    def numpy(self, function: str, x, u, p, h=None) -> np.ndarray:
        """Evaluate one of the model's own functions at stacked vectors."""
        model = self.model
        x, u = unpack(model.state, x), unpack(model.input, u)
        p = unpack(model.parameters, p)
        d = derived(model, p)
        if function == "step":
            x_next, y = model.step(x, u, p, float(model.period), *d)
            return np.concatenate([pack(x_next), pack(y)])
        timed = (h,) if function == "advance" else ()
        return pack(getattr(model, function)(x, u, p, *timed, *d))

    def casadi(self, function: str, x, u, p, h=None) -> tuple[np.ndarray, float]:
        """Evaluate the traced function; return also its largest intermediate."""
        T_s = 0.0 if self.continuous else float(self.model.period)
        d = self.traced.functions["prepare"](p, T_s)
        last = {"step": (T_s,), "advance": (h,)}.get(function, ())
        arguments = (x, u, p, d, *last)
        results = self.traced.functions[function].call(list(map(ca.DM, arguments)))
        everything = intermediates(self.traced.functions[function])(*arguments)
        largest = np.max(np.abs(everything.full()), initial=1e-300)
        return np.concatenate([np.ravel(r.full()) for r in results]), largest

    def start(self) -> list[np.ndarray]:
        model = self.model
        return [pack(r) for r in (model.state, model.input, model.parameters)]

    def random_point(self, random: np.random.Generator) -> list[np.ndarray]:
        model = self.model
        x = [_scattered(leaf, random) for leaf in leaves(model.state)]
        u = [_scattered(leaf, random) for leaf in leaves(model.input)]
        p = [_perturbed(leaf, random) for leaf in leaves(model.parameters)]
        return [np.concatenate([np.zeros(0), *parts]) for parts in (x, u, p)]

    def inputs(self) -> np.ndarray:
        """A smooth command and multi-sines of plausible size; (STEPS, n_u)."""
        t = np.arange(STEPS) * self.h
        columns = []
        for leaf in leaves(self.model.input):
            for _ in range(np.size(leaf.value)):
                i = len(columns)
                if leaf.name in COMMAND and leaf.var.unit.startswith("rad"):
                    columns.append(command(self.h)[leaf.name])
                elif leaf.boolean:
                    columns.append((np.arange(STEPS) // 100) % 2)
                else:
                    size = leaf.var.nominal or SIZES.get(leaf.var.unit, 1.0)
                    hertz = (7.0 + 2.3 * i, 31.0 + 3.1 * i, 83.0 + 1.7 * i)
                    waves = (
                        np.sin(2 * np.pi * f * t + i) / (n + 1)
                        for n, f in enumerate(hertz)
                    )
                    columns.append(size * sum(waves))
        return np.array(columns, dtype=float).T.reshape(STEPS, -1)

    @cached_property
    def expected(self) -> np.ndarray:
        """Outputs and states after each step by the NumPy equations."""
        model, rows = self.model, []
        x, p = model.state, model.parameters
        d = derived(model, p)
        inputs = self.inputs()
        for k in range(STEPS):
            arrived = [inputs[max(0, k - late), i] for i, late in self.late.items()]
            u = unpack(model.input, np.array(arrived))
            if self.continuous:
                n = max(1, int(np.ceil(self.h / model.h_max - 1e-6)))
                for _ in range(n):
                    x = advance(model, x, u, p, d, self.h / n)
                y = model.output(x, u, p, *d)
            else:
                x, y = model.step(x, u, p, self.h, *d)
            rows.append(np.concatenate([pack(y), pack(x)]))
        return np.array(rows)


SIZES = {"m": 1e-2, "rad/s": 10.0, "N": 50.0, "m/s": 0.1, "m/s2": 1.0, "um": 10.0}
COMMAND = ("x_r", "v_r", "a_r", "j_r", "s_r")
subject = cache(Subject)


def _scattered(leaf: Any, random: np.random.Generator) -> np.ndarray:
    start = np.ravel(np.asarray(leaf.value, dtype=float))
    if leaf.boolean:
        return random.integers(0, 2, start.size).astype(float)
    if leaf.var.unit == "1" and np.all(start == np.floor(start)):
        return random.integers(0, 20_000, start.size).astype(float)
    size = leaf.var.nominal or SIZES.get(leaf.var.unit, 1.0)
    return start + size * random.normal(size=start.size)


def _perturbed(leaf: Any, random: np.random.Generator) -> np.ndarray:
    start = np.ravel(np.asarray(leaf.value, dtype=float))
    if leaf.var.constant or leaf.var.fixed:
        return start
    if leaf.boolean:
        return random.integers(0, 2, start.size).astype(float)
    low = -np.inf if leaf.var.min is None else leaf.var.min
    high = np.inf if leaf.var.max is None else leaf.var.max
    return np.clip(start * random.uniform(0.9, 1.1, start.size), low, high)


@cache
def command(h: float) -> dict[str, np.ndarray]:
    """Samples of the trajectory generator's outputs every h seconds."""
    model = import_module("controllers.references.trajectory").model
    x, d = model.state, (model.prepare(model.parameters, h),)
    rows = []
    for _ in range(STEPS):
        x, y = model.step(x, model.input, model.parameters, h, *d)
        rows.append(y)
    return {name: np.array([getattr(y, name) for y in rows]) for name in COMMAND}


def advance(model, x, u, p, d, h):
    """One substep: the model's own, or classical Runge-Kutta."""
    if model.advance is not None:
        return model.advance(x, u, p, h, *d)

    def f(state: np.ndarray) -> np.ndarray:
        return pack(model.derivative(unpack(model.state, state), u, p, *d))

    z = pack(x)
    k_1 = f(z)
    k_2 = f(z + h / 2 * k_1)
    k_3 = f(z + h / 2 * k_2)
    k_4 = f(z + h * k_3)
    return unpack(model.state, z + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4))


@cache
def intermediates(function: ca.Function) -> ca.Function:
    """Return a function that gives every number a traced function computes."""
    arguments = function.sx_in()
    work: dict[int, ca.SX] = {}
    seen = [ca.SX(0)]
    for k in range(function.n_instructions()):
        operation, taken = function.instruction_id(k), function.instruction_input(k)
        if operation == ca.OP_OUTPUT:
            continue
        if operation == ca.OP_CONST:
            value = ca.SX(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            value = arguments[taken[0]].nz[taken[1]]
        elif len(taken) == 1:
            value = ca.SX.unary(operation, work[taken[0]])
        else:
            value = ca.SX.binary(operation, work[taken[0]], work[taken[1]])
        work[function.instruction_output(k)[0]] = value
        seen.append(value)
    return ca.Function("intermediates", arguments, [ca.vertcat(*seen)])


class Instance:
    """An FMU of either version, driven by the vectors of its layout."""

    def __init__(self, fmu: Path, fmi: int, folder: Path, places: Any) -> None:
        fmpy.extract(str(fmu), str(folder))
        description = read_model_description(str(folder), validate=False)
        kind = fmpy.fmi2.FMU2Slave if fmi == 2 else fmpy.fmi3.FMU3Slave
        self.fmi, self.layout = fmi, places
        self.slave = kind(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="instance",
        )
        self.slave.instantiate()
        if fmi == 2:
            self.slave.setupExperiment()
        self.slave.enterInitializationMode()

    def set(self, block: str, vector: np.ndarray) -> None:
        first = self.layout.offset[block]
        for boolean in (False, True):
            chosen = [
                v
                for v in self.layout.block(block)
                if v.boolean == boolean and not v.var.constant
            ]
            values = [
                float(vector[v.reference - first + i])
                for v in chosen
                for i in range(v.size)
            ]
            if not chosen:
                continue
            if self.fmi == 2:
                references = [r for v in chosen for _, r in v.elements()]
                if boolean:
                    self.slave.setBoolean(references, [value != 0 for value in values])
                else:
                    self.slave.setReal(references, values)
            elif boolean:
                self.slave.setBoolean([v.reference for v in chosen], values)
            else:
                self.slave.setFloat64([v.reference for v in chosen], values)

    def get(self, *blocks: str) -> np.ndarray:
        chosen = [v for block in blocks for v in self.layout.block(block)]
        if not chosen:
            return np.zeros(0)
        if self.fmi == 2:
            return np.array(
                self.slave.getReal([r for v in chosen for _, r in v.elements()])
            )
        size = sum(v.size for v in chosen)
        return np.array(self.slave.getFloat64([v.reference for v in chosen], size))

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()
