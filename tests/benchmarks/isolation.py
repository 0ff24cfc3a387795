"""(e) FMUs in processes of their own: what a step costs, free and beside other work.

Run as a program it measures one case: how many FMUs, apart or not, how many steps.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

from fmus.build import build
from orchestrator.master.simulate import simulate
from orchestrator.system import Component, Isolation, System

LAG = Path(__file__).with_name("models") / "lag.py"
CASES = {  # FMUs, programs that compute beside, runs at once, steps
    "one FMU": (1, 0, 1, 200_000),
    "two FMUs": (2, 0, 1, 50_000),
    "three FMUs": (3, 0, 1, 50_000),
    "one FMU, two such runs at once": (1, 0, 2, 50_000),
    "one FMU beside a program that computes on every core": (1, None, 1, 20_000),
    "two FMUs beside a program that computes on every core": (2, None, 1, 10_000),
}
COMPUTE = "while True: pass"
ROUNDS = 5


def isolation() -> list[str]:
    """Return the section of the report."""
    cores = len(os.sched_getaffinity(0))
    lines = [
        f"## (e) FMUs in processes of their own, {cores} cores: us per step of an FMU "
        "(set, doStep, get)",
        "",
        "| case | in our process | in its own: median | least to most |",
        "|---|---|---|---|",
    ]
    for label, (n, beside, at_once, steps) in CASES.items():
        print(f"isolation: {label}", flush=True)
        with _computing(cores if beside is None else beside):
            ours = statistics.median(_run(n, False, at_once, steps))
            apart = [x for _ in range(ROUNDS) for x in _run(n, True, at_once, steps)]
        lines.append(
            f"| {label} | {ours:.2f} | {statistics.median(apart):.2f} | "
            f"{min(apart):.2f} to {max(apart):.2f} |"
        )
    return lines


@contextmanager
def _computing(n: int) -> Iterator[None]:
    programs = [subprocess.Popen([sys.executable, "-c", COMPUTE]) for _ in range(n)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


def _run(n: int, apart: bool, at_once: int, steps: int) -> list[float]:
    command = [sys.executable, __file__, str(n), str(int(apart)), str(steps)]
    runs = [
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        for _ in range(at_once)
    ]
    return [float(run.communicate()[0]) for run in runs]


def main(n: int, apart: int, steps: int) -> None:
    """Print the time of a step of one FMU (us)."""
    names = [f"lag_{i}" for i in range(n)]
    T = Fraction(1, 20_000)
    where = Isolation(process=bool(apart))
    fmu = build(str(LAG))
    components = {name: Component(name, fmu, T, isolation=where) for name in names}
    wires = {f"{name}.u": f"{names[i - 1]}.y" for i, name in enumerate(names)}
    ring = System("ring", steps * T, components, wires, {"lag_0.y": (20 * T,)})
    with tempfile.TemporaryDirectory() as folder:
        timing = simulate(ring, Path(folder) / "run").timing
    print(1e6 * timing.wall_s / (steps * n))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
