"""The elementary functions of ``fmus/native``: exact to 1 ulp, the same everywhere."""

import ctypes
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import mpmath
import numpy as np
import pytest
from modules import MODULES
from subject import subject

from fmus.compile import PLATFORMS, host_platform
from fmus.tangent import tangent
from fmus.trace import OWN, c_code

NATIVE = Path(__file__).parents[2] / "fmus" / "native"
ZIG = [sys.executable, "-m", "ziglang", "cc", "-fno-sanitize=undefined"]
ZIG += ["-target", PLATFORMS[host_platform()].triple]
FUNCTIONS = ("exp", "expm1", "log", "sin", "cos", "tan", "atan", "tanh", "sinh", "cosh")
FUNCTIONS += ("pow",)
ONE = [name for name in FUNCTIONS if name != "pow"]
# exact by IEEE 754, hence the same in every C library
EXACT = {"floor", "ceil", "fabs", "sqrt"}
LOOP = """
void each_{0}(long n, const double *x, double *y) {{
    for (long i = 0; i < n; i++)
        y[i] = own_{0}(x[i]);
}}
"""
POW = """
void each_pow(long n, const double *x, const double *p, double *y) {
    for (long i = 0; i < n; i++)
        y[i] = own_pow(x[i], p[i]);
}
"""
NEAR = """
void each_sin_near(long n, const double *x, double *y) {
    for (long i = 0; i < n; i++)
        y[i] = own_sin_near(x[i]);
}
"""


def library(folder: Path, *flags: str, compiler: Sequence[str] = ZIG) -> ctypes.CDLL:
    """Compile loops over the functions, without the flag that forbids contraction."""
    file = folder / f"{compiler[0].rpartition('/')[2]}{'_'.join(flags)}.so"
    source = folder / "loops.c"
    text = "".join(LOOP.format(name) for name in ONE) + POW + NEAR
    source.write_text('#include "elementary.h"\n' + text)
    command = [*compiler, "-std=gnu99", "-shared", "-fPIC", *flags, f"-I{NATIVE}"]
    command += ["-o", str(file), str(source), "-lm"]
    subprocess.run(command, check=True, capture_output=True)
    return ctypes.CDLL(str(file))


@pytest.fixture(scope="module")
def compiled(tmp_path_factory) -> ctypes.CDLL:
    return library(tmp_path_factory.mktemp("own"), "-mcpu=baseline", "-O2")


def call(library: ctypes.CDLL, name: str, *arguments: np.ndarray) -> np.ndarray:
    y = np.empty_like(arguments[0])
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (*arguments, y)]
    getattr(library, f"each_{name}")(ctypes.c_long(y.size), *pointers)
    return y


def spread(random: np.random.Generator, low: float, high: float, n: int) -> np.ndarray:
    """Return numbers of both signs, even in their logarithm."""
    size = np.exp(random.uniform(np.log(low), np.log(high), n))
    return size * random.choice([-1.0, 1.0], n)


def arguments(name: str, n: int) -> tuple[np.ndarray, ...]:
    """Return where a function is easy, where it is hard, and up to its limits."""
    random = np.random.default_rng(7)
    near, wide = random.uniform(-3, 3, n // 3), spread(random, 1e-300, 20, n // 3)
    match name:
        case "exp":
            limits = random.uniform(-745, 709.7, n // 3)
        case "log":
            near, wide = np.exp(near / 3), np.abs(spread(random, 1e-323, 1, n // 3))
            limits = np.abs(spread(random, 1, 1.7e308, n // 3))
        case "sin" | "cos" | "tan":
            turns = np.round(random.uniform(-1e6, 1e6, n // 6)) * (np.pi / 2)
            limits = np.concatenate([turns, spread(random, 1e4, 1.7e308, n // 6)])
        case "expm1" | "tanh":
            limits = random.uniform(-45, 45, n // 3)
        case "pow":
            x = np.concatenate([np.exp(near), np.exp(200 * near)])
            reach = 700 / np.maximum(np.abs(np.log(x)), 1e-3)
            return x, random.uniform(-1, 1, x.size) * reach
        case _:
            limits = random.uniform(-710, 710, n // 3)
    return (np.concatenate([near, wide, limits]),)


def ulps(got: float, true: mpmath.mpf) -> float:
    """Return the distance from the true value in units of its last place."""
    exponent = int(mpmath.frexp(true)[1]) if true else -2000
    place = mpmath.mpf(2) ** max(exponent - 53, -1074)
    return float(abs(mpmath.mpf(got) - true) / place)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_results_are_within_one_unit_of_the_last_place(name, compiled, request):
    n = 1_000_000 if request.config.getoption("--every-form") else 3_000
    x = arguments(name, n)
    true = mpmath.power if name == "pow" else getattr(mpmath, name)
    worst = 0.0
    for got, *at in zip(call(compiled, name, *x), *x, strict=True):
        huge = name in ("sin", "cos", "tan") and abs(at[0]) > 1e5
        with mpmath.workprec(1200 if huge else 120):
            worst = max(worst, ulps(float(got), true(*map(mpmath.mpf, map(float, at)))))
    assert worst <= 1.0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_at_the_edges_they_give_what_numpy_gives(name, compiled):
    small, large = [0.5, 1, 1.5, 2, 3, 22, 5e-324, 1e-310, 1e-8], [1.6e6, 1e22, 1e300]
    limits = [709.782712893384, 709.7827128933841, 710.475860073944, 711, 800]
    limits += [745.1332191019411, 745.1332191019412, 1.7976931348623157e308, np.inf]
    whole = [2.0**53 - 1, 2.0**53 + 2, 1 + 2**-52, 0.0]
    edges = np.array([*small, *large, *limits, *whole])
    edges = np.array([*edges, *-edges, np.nan])
    x: tuple[np.ndarray, ...] = (edges,)
    if name == "pow":
        pairs = np.meshgrid(edges, edges)
        x = tuple(np.ascontiguousarray(axis.ravel()) for axis in pairs)
    with np.errstate(all="ignore"):
        numpy = {"pow": "power", "atan": "arctan"}.get(name, name)
        expected = getattr(np, numpy)(*x)
        got = call(compiled, name, *x)
        same = (got == expected) & (np.signbit(got) == np.signbit(expected))
        same |= np.isnan(got) & np.isnan(expected)
        same |= np.abs(got - expected) <= 1.01 * np.spacing(np.abs(expected))
    assert same.all(), [axis[~same] for axis in x]


def test_vectors_of_any_width_and_fused_hardware_give_the_same_bits(compiled, tmp_path):
    others = [
        library(tmp_path, "-mcpu=baseline", "-O0"),
        library(tmp_path, "-mcpu=native", "-O3"),
    ]
    if shutil.which("gcc"):
        others.append(library(tmp_path, "-march=native", "-O3", compiler=["gcc"]))
    for name in FUNCTIONS:
        x = arguments(name, 30_000)
        expected = call(compiled, name, *x)
        for other in others:
            assert np.array_equal(call(other, name, *x), expected), name
    x = np.random.default_rng(8).uniform(-1.6e6, 1.6e6, 30_000)
    assert np.array_equal(call(compiled, "sin_near", x), call(compiled, "sin", x))


def test_own_functions_are_all_tried_here_and_exist_for_lanes():
    assert {*OWN.split("|")} == {*FUNCTIONS, "fmin", "fmax"}
    lanes = (NATIVE.parents[1] / "orchestrator/native/fused/lanes.h").read_text()
    for name in OWN.split("|"):
        assert re.search(rf"\b(ONE|NEAR)\({name}\)|\bv_{name}\(", lanes), name


def test_no_model_calls_a_function_of_the_c_library_that_is_not_exact():
    for module in MODULES:
        s = subject(module)
        functions = dict(s.traced.functions)
        if direction := tangent(s.model, s.traced):
            functions["tangent"] = direction
        called = set(re.findall(r"\b([a-z]\w*)\(", c_code(s.model, functions.values())))
        ours = {n for n in called if n.startswith(("own_", "casadi_"))}
        ours |= {n for n in called if n.startswith(tuple(functions))}
        assert called - ours - EXACT <= {"defined", "sizeof", "switch"}, module
