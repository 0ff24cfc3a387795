"""Ecos, timed: all steps in one call, nothing recorded.  Job on stdin."""

import json
import re
import runpy
import sys
from pathlib import Path
from time import perf_counter, process_time


def main() -> None:
    """Print seconds, steps, peak memory (bytes) and the last row."""
    job = json.load(sys.stdin)
    tool = runpy.run_path(job["tool"])
    tool["_load_tbb"]()
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    for name, component in job["components"].items():
        hint = job.get("hints", {}).get(name)
        structure.add_model(name, component["fmu"], step_size_hint=hint)
    for connection in job["connections"]:
        tool["_connect"](structure, connection)
    structure.add_parameter_set("given", tool["_parameters"](job))
    simulation = EcosSimulation(step_size=job["step"], structure=structure)
    if not simulation.init(0.0, "given"):
        raise SystemExit("Ecos did not initialise")
    begun = perf_counter(), process_time()
    simulation.step(job["count"])
    took = min(perf_counter() - begun[0], process_time() - begun[1])
    status = Path("/proc/self/status").read_text()
    told = {
        "seconds": took,
        "steps": job["count"],
        "peak": 1024 * int(re.search(r"VmHWM:\s+(\d+)", status)[1]),
        "last": tool["_row"](simulation, job)[1:],
    }
    print(json.dumps(told))


if __name__ == "__main__":
    main()
