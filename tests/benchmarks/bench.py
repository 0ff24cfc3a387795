"""``make bench``: the kernel against a C loop by hand and other tools.

Every figure is the median over rounds in which all tools run one after the
other, each in a process of its own; ratios are taken within a round.  Writes
docs/benchmarks.md.
"""

import argparse
import platform
import statistics
import tempfile
from collections.abc import Mapping
from datetime import date
from importlib.metadata import version
from pathlib import Path

from cost import cost
from exactness import exactness
from isolation import isolation
from measure import RUNNERS, Run, measure
from swept import swept
from workloads import GROWTH, STEPS

from fmus.compile import compiler_version
from orchestrator.peers.environment import PEERS, install
from orchestrator.peers.environment import version as peer_version

REPORT = Path(__file__).parents[2] / "docs" / "benchmarks.md"
OURS = ("kernel", "fused")
SLOW = ("python executor", "fmpy loop", "libcosim")
PERIOD = {"drive": 1 / 20_000}
TITLES = {
    "pair": "(a) two first-order lags in a ring, 1 kHz",
    "drive": "(b) ball-screw drive of the demo: trajectory, controller, plant, encoder "
    "at 20 kHz, 4 signals recorded",
}

Table = Mapping[str, list[Run]]


def main() -> None:
    """Measure, print and write the report."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory(prefix="feeddrive-bench-") as folder:
        place = Path(folder)
        tables = {name: interleaved(name, rounds, place) for name in STEPS}
        lines = [*header(rounds), *verdict(tables)]
        for name in ("pair", "drive"):
            lines += ["", f"## {TITLES[name]}", "", *rows(name, tables[name])]
        lines += ["", *growth(tables), "", *exactness(place / "exact")]
        lines += ["", *fused(tables), "", *swept(place), "", *cost(place / "cost")]
    lines += ["", *isolation()]
    text = "\n".join(lines) + "\n"
    REPORT.write_text(text, encoding="utf-8")
    print(text)


def interleaved(workload: str, rounds: int, folder: Path) -> Table:
    """Return the runs of every tool; slow ones take part in every third round."""
    runs: dict[str, list[Run]] = {tool: [] for tool in tools_for(workload)}
    for r in range(rounds):
        for tool in runs:
            if tool in SLOW and r % 3:
                continue
            print(f"{workload}, round {r + 1} of {rounds}: {tool}", flush=True)
            runs[tool].append(measure(tool, workload, folder) | {"round": r})
    return runs


def tools_for(workload: str) -> list[str]:
    """Return the tools that can run a workload in reasonable time."""
    large = workload in ("ring 50", "ring 200")
    without = SLOW if large else ()
    if workload != "drive":
        without = (*without, "one FMU")
    return [tool for tool in RUNNERS if tool not in without]


def per_step(run: Run) -> float:
    return 1e6 * float(run["seconds"]) / int(run["steps"])


def median(runs: list[Run]) -> float:
    return statistics.median(map(per_step, runs))


def ratio(table: Table, tool: str, to: str) -> float:
    """Return the median, over the rounds both took part in, of the ratio of times."""
    base = {run["round"]: per_step(run) for run in table[to]}
    return statistics.median(per_step(r) / base[r["round"]] for r in table[tool])


def rows(workload: str, table: Table) -> list[str]:
    period = PERIOD.get(workload, 1e-3)
    lines = [
        "| tool | us per macro step | ratio to the C loop | x real time | peak MB |",
        "|---|---|---|---|---|",
    ]
    for tool, runs in table.items():
        us, peak = median(runs), max(run["peak"] for run in runs) / 1e6
        lines.append(
            f"| {tool} | {us:.3g} | {ratio(table, tool, 'C loop'):.2f} | "
            f"{1e6 * period / us:.3g} | {peak:.0f} |"
        )
    return lines


def growth(tables: Mapping[str, Table]) -> list[str]:
    names = [tool for tool in RUNNERS if tool in tables["ring 200"]]
    lines = [
        "## (c) n first-order lags in a ring, all recorded: us per macro step",
        "",
        "| n | " + " | ".join(names) + " | kernel / C loop | kernel, us per FMU |",
        "|---|" + "---|" * (len(names) + 2),
    ]
    for n in GROWTH:
        table = tables[f"ring {n}"]
        times = " | ".join(f"{median(table[tool]):.3g}" for tool in names)
        over = ratio(table, "kernel", "C loop")
        each = median(table["kernel"]) / n
        lines.append(f"| {n} | {times} | {over:.2f} | {each:.3f} |")
    return lines


def fused(tables: Mapping[str, Table]) -> list[str]:
    """Return what the fused loop takes of the C loop, with its target."""
    lines = [
        "## (f) the fused loop: our equations in one function, no FMI between them",
        "",
        "| workload | us per macro step | ratio to the C loop | target |",
        "|---|---|---|---|",
    ]
    for name, table in tables.items():
        found, most = ratio(table, "fused", "C loop"), 0.6 if name == "drive" else 1.0
        met = "" if found <= most else " **missed**"
        us = median(table["fused"])
        lines.append(f"| {name} | {us:.3g} | {found:.2f}{met} | {most} |")
    return lines


def verdict(tables: Mapping[str, Table]) -> list[str]:
    """Say which targets are met."""
    lines = [
        "| target | " + " | ".join(tables) + " |",
        "|---" * (len(tables) + 1) + "|",
    ]
    for tool, to, limit in (
        ("kernel", "C loop", 1.3),
        ("fused", "C loop", 1.0),
        ("fmucontainer", "kernel", 1.0),
        ("ecos", "kernel", 2.0),
        ("libcosim", "kernel", 20.0),
    ):
        cells = []
        for table in tables.values():
            if tool not in table:
                cells.append("-")
                continue
            found = ratio(table, tool, to)
            met = found <= limit if tool in OURS else found >= limit
            cells.append(f"{found:.2f}" + ("" if met else " **missed**"))
        sign = "<=" if tool in OURS else ">="
        lines.append(f"| {tool} / {to} {sign} {limit:g} | " + " | ".join(cells) + " |")
    return lines


def header(rounds: int) -> list[str]:
    peers = [
        f"{name} {peer_version(peer, install(peer))}" for name, peer in PEERS.items()
    ]
    return [
        "# Benchmarks",
        "",
        f"Written by `make bench` on {date.today()}: {processor()}, "
        f"{platform.platform()}, Python {platform.python_version()}, "
        f"zig {compiler_version()}, numpy {version('numpy')}, "
        f"pyarrow {version('pyarrow')}; {', '.join(peers)}.",
        "",
        f"Medians of {rounds} interleaved rounds (slow tools: every third), each run "
        "in a process of its own, all on the same native FMI 2.0 FMU files; ratios "
        "are medians of the ratios within a round. Time is that of stepping, without "
        "loading, on the processor (of tools with threads the clock's, if that is "
        "less), so that other work on the machine counts for little. The C loop is "
        "straight-line code generated for the one system, with "
        "the same calls, checks and rows (written raw). Kernel and fused loop write "
        "Arrow streams. FMUContainer, and the one FMU that we make of the drive, are "
        "driven by a C loop too; the fmpy loop reads "
        "the signals; Ecos and libcosim record nothing and take all steps in one "
        "call. The peers exchange after each step only.",
        "",
    ]


def processor() -> str:
    """Return the name of the processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    names = [x.partition(":")[2].strip() for x in lines if x.startswith("model name")]
    return f"{len(names)} x {names[0]}" if names else platform.processor()


if __name__ == "__main__":
    main()
