"""FMUs made of one C file, for tests of what our own exporter would never make."""

import zipfile
from pathlib import Path

from fmus.compile import PLATFORMS, compile_alone, host_platform

SOURCES = Path(__file__).parents[1] / "orchestrator" / "broken"
MODES = (
    "well",
    "segfault",
    "hang",
    "error",
    "fatal",
    "discard",
    "nan",
    "exit",
    "thread",
    "memory",
    "abort",
    "hang_when_freed",
)
MISBEHAVES = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Misbehaves" guid="{0}">
  <CoSimulation modelIdentifier="misbehaves"
    canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"
      variability="continuous"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"
      variability="continuous"><Real/></ScalarVariable>
    <ScalarVariable name="at" valueReference="2" causality="parameter"
      variability="fixed"><Real start="1e9"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="3" causality="parameter"
      variability="fixed"><Integer start="0"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies="1"/></Outputs>
  </ModelStructure>
</fmiModelDescription>
"""


def pack(
    source: str, description: str, folder: Path, fmi: int = 2, host: str | None = None
) -> Path:
    """Return an FMU of ``broken/<source>.c``; ``host`` is the folder of its binary."""
    platform = PLATFORMS[host_platform()]
    text = (SOURCES / f"{source}.c").read_text(encoding="utf-8")
    library = compile_alone(
        source, {f"{source}.c": text}, platform.name, folder / "libraries"
    )
    place = platform.fmi2_folder if fmi == 2 else platform.fmi3_folder
    fmu = folder / f"{source}.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{host or place}/{library.name}")
    return fmu
