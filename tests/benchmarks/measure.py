"""One timed run of one workload in one tool, each in a process of its own."""

import json
import subprocess
import sys
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from limit import limit_source
from workloads import STEPS, driven, system

from fmus.compile import FLAGS
from orchestrator.exchange.whole.export import export_whole
from orchestrator.master.simulate import plan
from orchestrator.peers.environment import PEERS, install
from orchestrator.peers.second_opinion import peer_job
from orchestrator.system import Component, System

HERE = Path(__file__).parent
TOOLS = HERE / "tools"
PEER_FILES = HERE.parents[1] / "orchestrator" / "peers"

Run = dict[str, Any]
# per tool, the share of the steps of the C loop that it is given
SHARE = {"libcosim": 0.02, "python executor": 0.02, "fmpy loop": 0.02, "ecos": 0.5}


def measure(tool: str, workload: str, folder: Path) -> Run:
    """Return ``seconds``, ``steps``, ``peak`` (bytes) and the ``last`` row."""
    steps = max(500, int(STEPS[workload] * SHARE.get(tool, 1.0)))
    return RUNNERS[tool](workload, steps, folder)


def ours(executor: str) -> Callable[[str, int, Path], Run]:
    def run(workload: str, steps: int, folder: Path) -> Run:
        command = [sys.executable, str(TOOLS / "ours.py"), executor, workload]
        return _told([*command, str(steps), str(folder / executor)])

    return run


def limit(workload: str, steps: int, folder: Path) -> Run:
    program = _program(workload, steps, folder)
    return _told([str(program), str(folder / "limit.rows")])


def container(workload: str, steps: int, folder: Path) -> Run:
    program = _contained(workload, steps, folder)
    return _told([str(program), str(folder / "container.rows")])


def one_fmu(workload: str, steps: int, folder: Path) -> Run:
    program = _exported(steps, folder)
    return _told([str(program), str(folder / "whole.rows")])


@cache
def _exported(steps: int, folder: Path) -> Path:
    """Return a C loop on the one FMU that we make of the drive."""
    place = folder / f"whole-{steps}"
    composition = driven()
    fmu = export_whole(composition, place / "whole.fmu")
    (period,) = {c.period for c in composition.system.components.values()}
    whole = {"whole": Component("whole", fmu, period)}
    rows = {f"whole.{name}": (period,) for name in composition.system.record}
    given = System("whole", steps * period, whole, {}, rows)
    return compiled(given, place / "loop")


@cache
def _program(workload: str, steps: int, folder: Path) -> Path:
    return compiled(system(workload, steps), folder / f"limit-{workload}-{steps}")


def compiled(given: System, folder: Path) -> Path:
    """Return the C loop of a system, compiled like the FMUs."""
    folder.mkdir(parents=True)
    timetable = plan(given)
    fmus = {part.fmu.path for part in timetable.wiring.parts.values()}
    places = {}
    for i, fmu in enumerate(sorted(fmus)):
        places[fmu] = folder / f"fmu{i}"
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(places[fmu])
    source = folder / "limit.c"
    source.write_text(limit_source(timetable, places))
    program = folder / "limit"
    flags = [f for f in FLAGS if not f.startswith(("-W", "-std"))]
    command = [sys.executable, "-m", "ziglang", "cc", *flags, "-Wno-unused-function"]
    subprocess.run(
        [*command, str(source), "-o", str(program), "-ldl", "-lm"], check=True
    )
    return program


@cache
def _contained(workload: str, steps: int, folder: Path) -> Path:
    """Return a C loop on the one FMU that FMUContainer makes of a system."""
    place = folder / f"container-{workload}-{steps}"
    place.mkdir(parents=True)
    job = peer_job(plan(system(workload, steps)).wiring) | {"folder": str(place)}
    peer = PEERS["fmucontainer"]
    command = [str(install(peer)), str(PEER_FILES / "child.py")]
    subprocess.run(
        [*command, str(PEER_FILES / peer.file), str(place / "none")],
        input=json.dumps(job),
        text=True,
        check=True,
        cwd=place,
        stdout=subprocess.DEVNULL,
    )
    period = Fraction(*job["period"])
    fmu = Component("container", place / "container.fmu", period)
    rows = {f"container.seen.{c}.{v}": (period,) for c, v, *_ in job["signals"]}
    given = System("container", steps * period, {"container": fmu}, {}, rows)
    return compiled(given, place / "loop")


def peer(name: str, file: str) -> Callable[[str, int, Path], Run]:
    def run(workload: str, steps: int, folder: Path) -> Run:
        given = system(workload, steps)
        components = {n: replace(c, latency=0) for n, c in given.components.items()}
        job = peer_job(plan(replace(given, components=components)).wiring)
        return carry_out(name, file, job, folder)

    return run


def carry_out(name: str, file: str, job: Mapping[str, Any], folder: Path) -> Run:
    """Return what a tool of another environment measures of a job."""
    found = PEERS[name]
    extra = {"folder": str(folder), "tool": str(PEER_FILES / found.file)}
    return _told([str(install(found)), str(TOOLS / file)], json.dumps({**job, **extra}))


def _told(command: list[str], job: str = "") -> Run:
    done = subprocess.run(command, input=job, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command[:3])}: {done.stderr.strip()[-500:]}")
    told: Run = json.loads(done.stdout.strip().splitlines()[-1])
    return told


RUNNERS: Mapping[str, Callable[[str, int, Path], Run]] = {
    "C loop": limit,
    "kernel": ours("kernel"),
    "fused": ours("fused"),
    "one FMU": one_fmu,
    "python executor": ours("python"),
    "fmucontainer": container,
    "ecos": peer("ecospy", "ecos.py"),
    "fmpy loop": peer("fmpy", "raw_loop.py"),
    "libcosim": peer("libcosimpy", "libcosim.py"),
}
