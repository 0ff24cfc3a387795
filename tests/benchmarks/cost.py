"""(h) what a member of a sweep costs beside stepping, an FMU of others in the system.

Run as a program it carries out one sweep: its folder, the stop, members or one.
"""

import json
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path

from workloads import DRIVE

from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Axis
from orchestrator.scenario.reading import load_scenario
from orchestrator.supplied import build_supplied

ROUNDS, STOP = 3, 0.1  # s
AXES = (
    Axis("plant.m_2", (0.35e-3, 0.37e-3, 0.39e-3, 0.41e-3)),
    Axis("controller.latency", ("0", "1", "2")),
    Axis("rates.control", ("10 kHz", "15 kHz", "20 kHz")),
)
SCENARIO = """
base = "{base}"
[components.plant]
fmu = "{fmu}"
step = "control"
[components.plant.map]
u = {{ name = "motor_voltage", gain = -1 }}
x_1 = {{ name = "screw", gain = 0.314159265, unit = "rad" }}
x_2 = {{ name = "table", gain = 0.314159265, unit = "rad" }}
m_1 = {{ name = "inertia_motor", unit = "V.s2/rad" }}
m_2 = {{ name = "inertia_table", unit = "V.s2/rad" }}
b_1 = {{ name = "bearing", unit = "V.s/rad" }}
k = {{ name = "stiffness", unit = "V/rad" }}
c = {{ name = "nut", unit = "V.s/rad" }}
r_g = {{ name = "lead", unit = "m/rad" }}
[design.gains]
arguments = {{ b_2 = 0 }}
"""


def cost(folder: Path) -> list[str]:
    """Return the section of the report."""
    folder.mkdir(parents=True)
    fmu = build_supplied("supplied.ball_screw", folder)
    base = load_scenario(DRIVE).file
    (folder / "drive.toml").write_text(SCENARIO.format(base=base, fmu=fmu))
    _cpu(folder, STOP, "all")  # builds what is not yet in the cache
    found = []
    for r in range(ROUNDS):
        print(f"cost of a member, round {r + 1} of {ROUNDS}", flush=True)
        one, n = _cpu(folder, STOP, "one"), 36
        whole, longer = (_cpu(folder, t, "all") for t in (STOP, 2 * STOP))
        stepping = (longer - whole) / n
        found.append((one, (whole - one) / (n - 1) - stepping, stepping))
    first, beside, stepping = (
        1e3 * statistics.median(x) for x in zip(*found, strict=True)
    )
    met = "" if beside <= 30 else " **missed**"
    return [
        "## (h) 36 members mass x delay x rate, the plant an FMU of others in a "
        "process of its own: ms of CPU",
        "",
        f"All processes counted; load of the machine (1 min) {os.getloadavg()[0]:.1f}.",
        "",
        "| what | ms |",
        "|---|---|",
        f"| per member, beside stepping (at most 30) | {beside:.0f}{met} |",
        f"| stepping a member for {STOP} s | {stepping:.0f} |",
        f"| a sweep of one member, once, all included | {first:.0f} |",
    ]


def _cpu(folder: Path, stop: float, which: str) -> float:
    """Return the CPU time (s) of a sweep."""
    command = [sys.executable, __file__, str(folder), str(stop), which]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return float(json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """Print the CPU time of one sweep, its processes included."""
    folder, stop, which = sys.argv[1:]
    axes = AXES if which == "all" else [Axis(a.key, a.values[:1]) for a in AXES]
    before = _used()
    found = sweep(Path(folder, "drive.toml"), list(axes), sets=[f"stop={stop}"])
    assert not found.failed
    print(_used() - before)


def _used() -> float:
    both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(of.ru_utime + of.ru_stime for of in both)


if __name__ == "__main__":
    main()
