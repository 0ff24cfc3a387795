"""An FMI 3.0 FMU of no exporter that a clock ticks (broken/clocked.c)."""

from pathlib import Path

from broken import SOURCES
from foreign import compile_source, packed

PERIODIC = 'intervalVariability="constant" intervalDecimal="0.001"'


def clocked(folder: Path, clock: str = PERIODIC, events: bool = True) -> Path:
    """Build one into a folder; ``clock`` are the attributes of its input clock."""
    folder.mkdir(parents=True, exist_ok=True)
    library = compile_source(3, SOURCES / "clocked.c", folder, (), {})
    lines = [
        f'<Float64 name="{name}" valueReference="{i}" causality="output"/>'
        for i, name in enumerate("nywz")
    ]
    lines.append('<Float64 name="u" valueReference="4" causality="input" start="0"/>')
    lines.append(f'<Clock name="c" valueReference="9" causality="input" {clock}/>')
    needs = {"n": "", "y": "4", "w": "", "z": ""}
    structure = "".join(
        f'<Output valueReference="{i}" dependencies="{needs[name]}"/>'
        for i, name in enumerate(needs)
    )
    mode = 'hasEventMode="true"' if events else ""
    description = (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="3.0" '
        'instantiationToken="x" modelName="Clocked"><CoSimulation '
        f'modelIdentifier="clocked" canHandleVariableCommunicationStepSize="true" '
        f"{mode}/><ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
    return packed(3, folder, library, description)
