"""Initial circles: one Newton's method, the same bits from every executor."""

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from systems import part, system

from fmus.compile import compile_alone, host_platform
from fmus.native_source import adapter_sources
from orchestrator.errors import SimulationError
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.fused.library import ELEMENTARY, HEADERS
from orchestrator.master.initialise import SUBSTITUTIONS
from orchestrator.master.newton import Refused, newton, settled
from orchestrator.master.simulate import plan, simulate
from orchestrator.system import System

N = 3
SHIM = f"""
#define W 1
#include "lanes.h"
enum {{ CIRCLE = {N}, SUBSTITUTIONS = {SUBSTITUTIONS} }};
#include "circle.h"
#define OUT __attribute__((visibility("default")))
static Circle c;
OUT void begin(double *asked) {{ circles_begin(&c, asked); }}
OUT int next(double *asked, const double *given, double bad) {{
    int going = circles_next(&c, asked, given, bad, 1);
    if (!going && !circles_failed(&c)) circles_found(&c, asked);
    return going ? 1 : circles_failed(&c) ? 2 : 0;
}}
"""
Around = Callable[[Sequence[float]], Sequence[float]]


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Any:
    sources = {"circle.c": SHIM}
    for name in ("lanes.h", "circle.h"):
        sources[name] = (HEADERS / name).read_text()
    sources |= {name: adapter_sources()[name] for name in ELEMENTARY}
    quiet = ["-Wno-unused-function"]
    folder = tmp_path_factory.mktemp("circle")
    return ctypes.CDLL(
        str(compile_alone("circle", sources, host_platform(), folder, flags=quiet))
    )


def problem(seed: int) -> tuple[Around, list[float]]:
    """Return a map of three numbers, steep enough for substitution to leave it."""
    random = np.random.default_rng(seed)
    a = (random.normal(size=(N, N)) * random.choice([0.3, 1, 3, 30])).tolist()
    b, curved = random.normal(size=N).tolist(), float(random.choice([0, 1, 3]))

    def around(z: Sequence[float]) -> Sequence[float]:
        if curved == 3 and min(z) < -8:
            raise Refused
        return [
            sum(k * x for k, x in zip(row, z, strict=True))
            + one
            + curved * math.tanh(z[i])
            for i, (row, one) in enumerate(zip(a, b, strict=True))
        ]

    return around, random.normal(size=N).tolist()


def by_machine(machine: Any, around: Around, start: list[float]) -> list[float] | None:
    """Return what circle.h finds: None if nothing."""
    asked = (ctypes.c_double * N)(*start)
    machine.begin(asked)
    going = 1
    while going == 1:
        try:
            given, bad = around(list(asked)), 0.0
        except Refused:
            given, bad = [0.0] * N, float("nan")
        going = machine.next(asked, (ctypes.c_double * N)(*given), ctypes.c_double(bad))
    return list(asked) if going == 0 else None


def by_python(around: Around, start: list[float]) -> list[float] | None:
    z = start
    try:
        for _ in range(SUBSTITUTIONS):
            before, z = z, list(around(z))
            if not all(map(math.isfinite, z)):
                break
            if settled(before, z):
                return z
    except Refused:
        pass
    try:
        return newton(around, start)
    except Refused:
        return None


def test_newtons_method_has_the_same_bits_in_python_and_in_c(machine: Any) -> None:
    found = []
    for seed in range(300):
        around, start = problem(seed)
        one = by_machine(machine, around, start)
        assert one == by_python(around, start)
        found.append(one)
    solved = [one for one in found if one is not None]
    assert 200 < len(solved) < 300  # some have no solution that is found
    for seed, one in enumerate(found):
        if one is not None:
            off = np.subtract(problem(seed)[0](one), one)
            # substitution goes round once more than it looks
            assert np.all(np.abs(off) <= 1e-11 * np.maximum(1, np.abs(one)))


def test_a_loop_of_gain_one_is_not_solved_far_away() -> None:
    """z = 0.3 z + 0.7 z + 0.1 has no solution; rounding gives it a slope of 1e-9."""

    def around(z: Sequence[float]) -> list[float]:
        return [0.3 * z[0] + 0.7 * z[0] + 0.1]

    for start in (0.37, 1.7, -5.3, 1e3):
        assert newton(around, [start]) is None


def circle(g: float, h: float) -> System:
    """z_a = x_a + g z_b and z_b = x_b + h z_a."""
    parts = [
        part(n, "integrator", "1/10", start={"state.x": x}, parameters={"g": k})
        for n, x, k in (("a", 1.0, g), ("b", 0.7, h))
    ]
    wires = {"a.u": "b.z", "b.u": "a.z"}
    return system("1/10", parts, wires, {"a.z": "1/10", "b.z": "1/10"})


def test_initial_circles_have_the_same_bits_in_every_executor(tmp_path: Path) -> None:
    """Substitution, Newton's method and both side by side in one vector."""
    gains = [0.5, -3.7, 1e3, 2.3]
    lanes = Lanes(plan(circle(0.1, 0.4)), frozenset(["a.z", "b.z"]), 4)
    members = list(lanes.run([{"a": {"g": g}} for g in gains]))
    for g, member in zip(gains, members, strict=True):
        given = circle(g, 0.4)
        assert not member.unsettled
        for executor in ("python", "kernel", "fused"):
            run = simulate(given, tmp_path / f"{executor} {g}", executor=executor)  # type: ignore[arg-type]
            for name, signal in run.items():
                bits = signal.values.view(np.int64)
                other = member.signals[name].values.view(np.int64)
                np.testing.assert_array_equal(bits, other)
        exact = (1 + g * 0.7) / (1 - g * 0.4)
        assert member.signals["a.z"].values[0] == pytest.approx(exact, rel=1e-9)


def test_a_circle_without_a_solution_is_refused_with_its_edges(tmp_path: Path) -> None:
    given = circle(1.0, 1.0)  # z_a = 1 + z_b, z_b = 0.7 + z_a
    (member,) = Lanes(plan(given), frozenset(["a.z"]), 4).run([{}])
    assert member.unsettled
    with pytest.raises(SimulationError, match=r"circle through .*b\.z -> a\.u"):
        simulate(replace(given), tmp_path)
