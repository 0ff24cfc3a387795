"""Every public model of plants and controllers, in every form it is shipped in.

The references are the model's own NumPy equations, integrated here.
"""

import re
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any
from zipfile import ZipFile

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from modules import EXCHANGED, MODULES
from scipy.integrate import solve_ivp

from fmus.build import build
from fmus.layout import layout
from fmus.model import Continuous, leaves, pack, unpack
from fmus.trace import trace

STEPS = 1000
SAME = 1e-12
REPRESENTATIVES = ("plants.ball_screw_drive", "controllers.mc_ppc", "plants.encoder")
LIVELIEST = ("plants.ball_screw_drive", "plants.gantry_drive")
PLATFORMS = (
    "linux-x86_64",
    "linux-aarch64",
    "windows-x86_64",
    "macos-x86_64",
    "macos-arm64",
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give each test its models: all, or those whose further forms are tested."""
    everything = metafunc.config.getoption("--every-form")
    if "module" in metafunc.fixturenames:
        metafunc.parametrize("module", MODULES)
    if "further" in metafunc.fixturenames:
        metafunc.parametrize("further", MODULES if everything else REPRESENTATIVES)
    if "exchanged" in metafunc.fixturenames:
        chosen = EXCHANGED if everything else LIVELIEST
        metafunc.parametrize("exchanged", chosen)


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
    model = import_module("controllers.trajectory").model
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


def close(got: np.ndarray, expected: np.ndarray, scale: Any, what: str) -> None:
    error = np.max(np.abs(got - expected) / scale, initial=0.0)
    assert error <= SAME, f"{what} differ by {error:.2g} of the scale"


def test_numpy_casadi_and_compiled_c_compute_the_same(module, tmp_path):
    s = subject(module)
    random = np.random.default_rng(20_260_101)
    points = [s.start(), *(s.random_point(random) for _ in range(4))]
    functions = [f for f in s.traced.functions if f != "prepare"]
    fmu = build(module)
    for n, (x, u, p) in enumerate(points):
        h = s.model.h_max if s.continuous else None
        results, scales = {}, {}
        for name in functions:
            results[name] = s.numpy(name, x, u, p, h)
            assert np.isfinite(results[name]).all(), f"{name} at {x}, {u}, {p}"
            traced, scales[name] = s.casadi(name, x, u, p, h)
            close(traced, results[name], scales[name], f"{name} of CasADi")
        instance = Instance(fmu, 2, tmp_path / str(n), s.layout)
        instance.set("parameter", p)
        instance.set("state", x)
        instance.set("input", u)
        instance.slave.exitInitializationMode()
        if s.continuous:
            close(
                instance.get("output"), results["output"], scales["output"], "C outputs"
            )
            der_x, scale = results["derivative"], scales["derivative"]
            close(instance.get("derivative"), der_x, scale, "C derivatives")
        instance.slave.doStep(0.0, s.h if h is None else h)
        if "advance" in functions:
            close(
                instance.get("state"), results["advance"], scales["advance"], "C states"
            )
        if "step" in functions:
            both = instance.get("state", "output")
            close(both, results["step"], scales["step"], "C states and outputs")
        instance.close()


def compare_run(s: Subject, fmu: Path, fmi: int, folder: Path) -> None:
    instance = Instance(fmu, fmi, folder, s.layout)
    inputs, rows = s.inputs(), []
    instance.set("input", inputs[0])
    instance.slave.exitInitializationMode()
    for k, row in enumerate(inputs):
        instance.set("input", row)
        instance.slave.doStep(k * s.h, s.h)
        rows.append(instance.get("output", "state"))
    instance.close()
    expected = s.expected
    assert np.isfinite(expected).all()
    scale = np.maximum(np.max(np.abs(expected), axis=0), 1e-300)
    close(np.array(rows), expected, scale, "a run of the FMU and of NumPy")


def test_native_fmus_are_valid_and_repeat_numpy_over_a_trajectory(module, tmp_path):
    for fmi in (2, 3):
        fmu = build(module, fmi=fmi)
        assert validate_fmu(str(fmu)) == []
        compare_run(subject(module), fmu, fmi, tmp_path / str(fmi))


def test_python_fmu_is_valid_and_repeats_numpy_over_a_trajectory(further, tmp_path):
    fmu = build(further, kind="python")
    assert validate_fmu(str(fmu)) == []
    compare_run(subject(further), fmu, 2, tmp_path / "python")


def test_start_values_of_the_description_are_those_of_the_instance(module, tmp_path):
    for fmi in (2, 3):
        fmu = build(module, fmi=fmi)
        s = subject(module)
        instance = Instance(fmu, fmi, tmp_path / str(fmi), s.layout)
        for v in read_model_description(str(fmu)).modelVariables:
            if v.start is None or v.type == "Boolean":
                continue
            told = [float(number) for number in v.start.split()]
            if fmi == 2:
                assert instance.slave.getReal([v.valueReference]) == told
            else:
                assert instance.slave.getFloat64([v.valueReference], len(told)) == told
        instance.slave.freeInstance()


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_integrates_to_the_same_trajectory(exchanged, fmi):
    s = subject(exchanged)
    x_0, _, p = s.start()
    u = s.inputs()[50]  # held, as kinks need event handling
    names = [n for v in s.layout.block("input") for n, _ in v.elements()]
    watched = [
        n
        for block in ("output", "state")
        for v in s.layout.block(block)
        for n, _ in v.elements()
    ]
    result = fmpy.simulate_fmu(
        str(build(exchanged, fmi=fmi)),
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=1e-13,
        stop_time=0.02,
        output_interval=1e-3,
        start_values=dict(zip(names, u, strict=True)),
        output=watched,
    )
    exact = solve_ivp(
        lambda _, x: s.numpy("derivative", x, u, p),
        (0.0, 0.02),
        x_0,
        method="DOP853",
        rtol=1e-12,
        atol=1e-18,
        t_eval=result["time"][1:-1],
    )
    for k in range(exact.t.size):
        x = exact.y[:, k]
        expected = np.concatenate([s.numpy("output", x, u, p), x])
        got = np.array([result[name][k + 1] for name in watched])
        scale = np.max(np.abs([result[name] for name in watched]), axis=1) + 1e-300
        assert np.max(np.abs(got - expected) / scale) < 1e-6


def test_every_platform_has_a_binary(further):
    for fmi, folders in ((2, 4), (3, 5)):  # FMI 2 has one folder for both Macs
        with ZipFile(build(further, fmi=fmi, platforms=PLATFORMS)) as archive:
            names = [n for n in archive.namelist() if n.startswith("binaries/")]
        assert len(names) == folders


def test_units_meanings_and_a_source_are_given(module):
    s = subject(module)
    for v in s.layout.variables:
        assert v.var.unit, f"{v.name} has no unit"
        assert v.var.description, f"{v.name} has no description"
    text = s.module.__doc__ or ""
    assert re.search(r"\((?:\D*\D)?(?:19|20)\d\d\b|\bSource:", text), (
        "no source is cited"
    )
