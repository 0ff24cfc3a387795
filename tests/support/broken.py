"""FMUs made of one C file, for tests of what our own exporter would never make."""

import re
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
    "equal_steps",
    "negative",
    "seven",
    "negative_get",
    "negative_set",
    "negative_start",
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


def without_co_simulation(fmu: Path, folder: Path) -> Path:
    """Return a copy of an FMU that only offers model exchange."""
    copy = folder / f"{fmu.stem}_me.fmu"
    with zipfile.ZipFile(fmu) as given, zipfile.ZipFile(copy, "w") as made:
        for member in given.infolist():
            content = given.read(member)
            if member.filename == "modelDescription.xml":
                content = re.sub(rb"<CoSimulation.*?(/>|</CoSimulation>)", b"", content)
            made.writestr(member, content)
    return copy


def ball(fmi: int) -> str:
    """Return the model description of ``ball.c``."""
    names = ("h", "v", "der_v", "u", "e", "kick", "t_kick", "bounces")
    kinds = {
        "u": ("input", "continuous", 'start="0"'),
        "e": ("parameter", "fixed", 'start="0.7"'),
        "kick": ("parameter", "fixed", 'start="0"'),
        "t_kick": ("parameter", "fixed", 'start="1e9"'),
        "bounces": ("output", "discrete", ""),
        "der_v": ("local", "continuous", ""),
        "h": ("output", "continuous", 'start="1" initial="exact"'),
        "v": ("output", "continuous", 'start="0" initial="exact"'),
    }
    two = fmi == 2
    lines = []
    for i, name in enumerate(names):
        causality, variability, start = kinds[name]
        start, _, initial = start.partition(" ")
        head = f'name="{name}" valueReference="{i}" causality="{causality}"'
        head += f' variability="{variability}" {initial}'
        state = {"v": "h", "der_v": "v"}.get(name)
        if two:
            derivative = f'derivative="{names.index(state) + 1}"' if state else ""
            real = f"<Real {start} {derivative}/>"
            lines.append(f"<ScalarVariable {head}>{real}</ScalarVariable>")
        else:
            derivative = f'derivative="{names.index(state)}"' if state else ""
            lines.append(f"<Float64 {head} {start} {derivative}/>")
    lines.append(
        ""
        if two
        else '<Float64 name="time" valueReference="99"'
        ' causality="independent" variability="continuous"/>'
    )
    if two:
        head = 'fmiVersion="2.0" guid="ball" numberOfEventIndicators="1"'
        outputs = "".join(f'<Unknown index="{i}"/>' for i in (1, 2, 8))
        rates = "".join(f'<Unknown index="{i}"/>' for i in (2, 3))
        structure = f"<Outputs>{outputs}</Outputs><Derivatives>{rates}</Derivatives>"
    else:
        head = 'fmiVersion="3.0" instantiationToken="ball"'
        structure = "".join(
            [f'<Output valueReference="{i}"/>' for i in (0, 1, 7)]
            + [f'<ContinuousStateDerivative valueReference="{i}"/>' for i in (1, 2)]
            + ['<EventIndicator valueReference="0"/>']
        )
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="Ball">'
        f'<ModelExchange modelIdentifier="ball"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
