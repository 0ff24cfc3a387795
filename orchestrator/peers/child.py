"""``python child.py <tool>.py <rows>``: one job in one tool, in this process.

The job is JSON on stdin: ``step`` (s), ``period`` [numerator, denominator],
``count`` of steps, ``folder`` to work in, ``components`` {name: {"fmu", "fmi",
"start"}}, ``connections`` {"source", "sink", "gain", "offset"} and ``signals``.
A variable is [component, name, reference, sort], a start value [name,
reference, sort, value].  The tool's file has ``rows(job)``, which yields one
row per time that the tool reports: its own time (s), then the signals.  Rows
are written as doubles.
"""

import json
import runpy
import sys
from array import array
from pathlib import Path


def main() -> None:
    """Run the job; what the tool objects to is the last line on stderr."""
    try:
        _run(*sys.argv[1:])
    except Exception as error:
        sys.exit(" ".join(str(error).split()) or type(error).__name__)


def _run(tool: str, target: str) -> None:
    job = json.load(sys.stdin)
    rows = runpy.run_path(tool)["rows"]
    with Path(target).open("wb") as file:
        for row in rows(job):
            array("d", row).tofile(file)
        file.flush()


if __name__ == "__main__":
    main()
