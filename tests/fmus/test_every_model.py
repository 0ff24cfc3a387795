"""Every public model of plants and controllers, in every form it is shipped in.

The references are the model's own NumPy equations, integrated here.
"""

import re
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from fmpy import read_model_description
from modules import EXCHANGED, MODULES
from scipy.integrate import solve_ivp
from subject import Instance, Subject, subject
from valid import problems

from fmus.build import build

SAME = 1e-12
REPRESENTATIVES = (
    "plants.ball_screw.drive",
    "controllers.ball_screw.mc_ppc",
    "plants.ball_screw.encoder",
    "controllers.ball_screw_lpv.k_vib",
)
LIVELIEST = (
    "plants.ball_screw.drive",
    "plants.gantry.drive",
    "plants.ball_screw_lpv.two_modes",
)
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
        assert problems(fmu) == []
        compare_run(subject(module), fmu, fmi, tmp_path / str(fmi))


def test_python_fmu_is_valid_and_repeats_numpy_over_a_trajectory(further, tmp_path):
    fmu = build(further, kind="python")
    assert problems(fmu) == []
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
    watched = s.layout.block("output") + s.layout.block("state")
    first = s.layout.offset["input"]
    starts, names = {}, []
    for v in s.layout.block("input"):  # FMI 3 names an array as a whole
        parts = v.elements() if fmi == 2 else [(v.name, v.reference)]
        for name, reference in parts:
            start = u[reference - first :][: 1 if fmi == 2 else v.size]
            starts[name] = start if v.shape and fmi == 3 else start[0]
    for v in watched:
        names += [n for n, _ in v.elements()] if fmi == 2 else [v.name]
    result = fmpy.simulate_fmu(
        str(build(exchanged, fmi=fmi)),
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=1e-13,
        stop_time=0.02,
        output_interval=1e-3,
        start_values=starts,
        output=names,
    )
    columns = [result[name].reshape(len(result), -1) for name in names]
    rows = np.hstack(columns).astype(float)
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
        scale = np.max(np.abs(rows), axis=0) + 1e-300
        assert np.max(np.abs(rows[k + 1] - expected) / scale) < 1e-6


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
