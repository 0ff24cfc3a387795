"""(d) A 125 us and a 200 us component together: who steps them when it should.

Each component is an FMU that counts its steps and keeps the length of the
last one (tests/support/foreign.c).
"""

import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

from measure import carry_out

from orchestrator.master.simulate import plan, simulate
from orchestrator.peers.second_opinion import peer_job
from orchestrator.system import Component, System

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from foreign import foreign

PERIODS = {"fast": Fraction(1, 8000), "slow": Fraction(1, 5000)}


def exactness(folder: Path) -> list[str]:
    """Return the section of the report."""
    folder.mkdir()
    fmu = foreign(2, folder)
    lines = [
        "## (d) 125 us and 200 us together for 1 s",
        "",
        "| tool | steps of the 125 us FMU | its last step | steps of the 200 us FMU | "
        "its last step |",
        "|---|---|---|---|---|",
    ]
    exact = [8000.0, 1.25e-4, 5000.0, 2e-4]
    lines.append(_line("exact", exact))
    for executor in ("kernel", "python"):
        rows = {
            f"{n}.{v}": (T,) for n, T in PERIODS.items() for v in ("steps", "length")
        }
        components = {n: Component(n, fmu, T) for n, T in PERIODS.items()}
        given = System("mixed", Fraction(1), components, {}, rows)
        found = simulate(given, folder / executor, executor=executor)
        lines.append(_line(executor, [float(found[name].values[-1]) for name in rows]))
    base = min(PERIODS.values())
    components = {n: Component(n, fmu, base) for n in PERIODS}
    rows = {f"{n}.{v}": (base,) for n in PERIODS for v in ("steps", "length")}
    one_rate: dict[str, Any] = peer_job(
        plan(System("one rate", Fraction(1), components, {}, rows)).wiring
    )
    hints = {n: float(T) for n, T in PERIODS.items()}
    for label, tool, file in (
        ("ecos, base 125 us, step hints", "ecospy", "ecos.py"),
        ("libcosim, 125 us (no rates)", "libcosimpy", "libcosim.py"),
        ("fmpy loop, 125 us", "fmpy", "raw_loop.py"),
    ):
        job = {**one_rate, "hints": hints, "observed": True}
        lines.append(_line(label, carry_out(tool, file, job, folder)["last"]))
    return lines


def _line(tool: str, values: list[float]) -> str:
    steps = [f"{values[i]:.0f} | {1e6 * values[i + 1]:.6g} us" for i in (0, 2)]
    return f"| {tool} | " + " | ".join(steps) + " |"
