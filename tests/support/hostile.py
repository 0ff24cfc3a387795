"""The hostile FMU (hostile.c), and what it may have left running."""

import os
from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).parents[1] / "orchestrator" / "broken" / "hostile.c"
HOW = (
    *("well", "writes", "closes", "cuts", "daemon", "constructor"),
    *("crash in terminate", "crash in free", "hang in terminate", "beyond", "before"),
    *("stops", "unmarked", "forges", "hang", "exit 0", "exit 0 in constructor"),
    *("hang in free", "crash", "aborts", "not a number", "returns error", "logs"),
    "escapes",
)
SLEEP = 1000 + os.getpid()  # s, by which "unmarked" of this process is known
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="hostile" guid="x">
  <CoSimulation modelIdentifier="hostile"
    canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"
      variability="continuous"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"
      variability="continuous"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies="1"/></Outputs>
  </ModelStructure>
</fmiModelDescription>
"""


def hostile_fmu(how: str, folder: Path) -> Path:
    """Return the FMU that attacks in this way."""
    defined = {"HOW": HOW.index(how), "SLEEP": SLEEP}
    library = compile_source(2, SOURCE, folder, (), defined)
    return packed(2, folder, library, DESCRIPTION)


def left_running(mark: str) -> list[str]:
    """Return the processes with this text in their environment, and the sleepers of
    "unmarked", which have none."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            marked = mark.encode() in (folder / "environ").read_bytes()
            called = (folder / "cmdline").read_bytes()
        except OSError:
            continue
        if called and (marked or called == b"sleep\0%d\0" % SLEEP):
            found.append(f"{folder.name} {called!r}")
    return found
