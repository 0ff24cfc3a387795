"""(g) members of a sweep: one core, the same equations, members and rows.

Lanes, the C loop carried out for each member, CasADi's ``map`` of one instant as
compiled C, and JAX's ``vmap`` of the same operations in float64, ``scan`` over the
instants (``tools/jax_members.py``, in an environment of its own).
"""

import ctypes
import json
import os
import statistics
import subprocess
import sys
from contextlib import chdir
from fractions import Fraction
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from instant import Instant, instant
from measure import TOOLS, _told, compiled
from workloads import DRIVE

from orchestrator.analysis.width import width
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.simulate import plan
from orchestrator.peers.environment import Peer, install, version
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

MEMBERS, ROUNDS = 64, 5
SHARE = 0.2  # of 1: masses vary by as much
JAX = Peer("jax", ("jax>=0.4",), "jax", "")
SIGNAL = "plant.x_2"


def swept(folder: Path) -> list[str]:
    """Return the section of the report."""
    system = compose(load_scenario(DRIVE), run_earlier).system
    one = instant(system)
    masses = [one.mass * f for f in np.linspace(1 - SHARE, 1 + SHARE, MEMBERS).tolist()]
    steps = int(system.stop / Fraction(1, 20_000))
    program = compiled(system, folder / "members-c")
    mapped = _compiled_map(one, folder / "map.so")
    lanes = Lanes(plan(system), frozenset(system.record), width())
    times: dict[str, list[float]] = {}
    for r in range(ROUNDS):
        print(f"members, round {r + 1} of {ROUNDS}", flush=True)
        loop = _told([str(program), str(folder / "one.rows")])
        found, took = _in_lanes(lanes, masses)
        of_map, took_map = _by_map(mapped, one, masses, steps)
        of_jax, took_jax = _by_jax(one, masses, steps)
        times.setdefault("C loop, member after member", []).append(loop["seconds"])
        times.setdefault(f"lanes, {lanes.width} wide", []).append(took / MEMBERS)
        times.setdefault("CasADi map, compiled", []).append(took_map / MEMBERS)
        times.setdefault("JAX vmap", []).append(took_jax / MEMBERS)
    base = times["C loop, member after member"]
    lines = [
        f"## (g) {MEMBERS} members of the drive, 4 signals of {steps + 1} rows each, "
        f"one core",
        "",
        f"The load of the machine (1 min) was {os.getloadavg()[0]:.1f}; "
        f"JAX {version(JAX, install(JAX))}. Final table positions of all members "
        f"differ from those of lanes by {_apart(found, of_map):.0e} (map) and "
        f"{_apart(found, of_jax):.0e} (JAX).",
        "",
        "| tool | ms per member | members per second and core | times the C loop |",
        "|---|---|---|---|",
    ]
    for tool, took in times.items():
        ratio = statistics.median(b / t for b, t in zip(base, took, strict=True))
        ms = 1e3 * statistics.median(took)
        lines.append(f"| {tool} | {ms:.3g} | {1e3 / ms:.3g} | {ratio:.2f} |")
    return lines


def _apart(one: Any, other: Any) -> float:
    return float(np.max(np.abs(np.asarray(one) - np.asarray(other))))


def _in_lanes(lanes: Lanes, masses: list[float]) -> tuple[list[float], float]:
    begun = process_time()
    members = list(lanes.run([{"plant": {"m_2": m}} for m in masses]))
    took = process_time() - begun
    return [float(m.signals[SIGNAL].values[-1]) for m in members], took


def _compiled_map(one: Instant, library: Path) -> Any:
    """Return CasADi's own C of the mapped instant, compiled for this processor."""
    source = library.with_suffix(".c")
    with chdir(source.parent):  # CasADi writes into the working directory only
        one.function.map(MEMBERS).generate(source.name)
    command = [sys.executable, "-m", "ziglang", "cc", "-O3", "-march=native", "-shared"]
    flags = ["-fPIC", "-fno-sanitize=undefined", str(source), "-o", str(library), "-lm"]
    subprocess.run([*command, *flags], check=True, capture_output=True)
    return ctypes.CDLL(str(library))


def _by_map(
    library: Any, one: Instant, masses: list[float], steps: int
) -> tuple[list[float], float]:
    """Carry all instants out: CasADi evaluates members one behind the other."""
    function = one.function.map(MEMBERS)
    name = function.name()
    x = np.tile(one.x, (MEMBERS, 1))
    p, d = one.parameters(masses)
    room = np.empty((2, MEMBERS, len(one.x)))
    rows = np.empty((steps + 1, MEMBERS, one.rows))
    room[0] = x
    call = getattr(library, name)
    call.argtypes = [ctypes.c_void_p] * 4 + [ctypes.c_int]
    work = np.zeros(max(1, function.sz_w()))
    iwork = np.zeros(max(1, function.sz_iw()), np.int64)
    argument = (ctypes.c_void_p * max(3, function.sz_arg()))()
    result = (ctypes.c_void_p * max(2, function.sz_res()))()
    begun = process_time()
    for k in range(steps + 1):
        argument[0] = room[k % 2].ctypes.data
        argument[1], argument[2] = p.ctypes.data, d.ctypes.data
        result[0], result[1] = room[(k + 1) % 2].ctypes.data, rows[k].ctypes.data
        call(
            ctypes.addressof(argument),
            ctypes.addressof(result),
            iwork.ctypes.data,
            work.ctypes.data,
            0,
        )
    took = process_time() - begun
    return rows[-1, :, one.row(SIGNAL)].tolist(), took


def _by_jax(one: Instant, masses: list[float], steps: int) -> tuple[list[float], float]:
    p, d = one.parameters(masses)
    job = {
        "source": one.python(),
        "x": one.x.tolist(),
        "p": p.tolist(),
        "d": d.tolist(),
        "steps": steps + 1,
        "row": one.row(SIGNAL),
    }
    environment = os.environ | {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
    done = subprocess.run(
        [str(install(JAX)), str(TOOLS / "jax_members.py")],
        input=json.dumps(job),
        text=True,
        capture_output=True,
        check=True,
        env=environment,
    )
    told = json.loads(done.stdout.splitlines()[-1])
    return told["last"], told["seconds"]
