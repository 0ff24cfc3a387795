"""FMUs of any names and types, for structures that others have drawn (stub.c)."""

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import fmpy
from foreign import compile_source

SOURCE = Path(__file__).with_name("stub.c")
FIRST = {"input": 0, "parameter": 1000, "output": 2000, "calculatedParameter": 2000}
BASES = {
    "m": 'm="1"',
    "mm": 'm="1" factor="0.001"',
    "rad": 'rad="1"',
    "deg": 'rad="1" factor="0.0174532925199433"',
    "N.m": 'kg="1" m="2" s="-2"',
}


class Stub(NamedTuple):
    """A variable: its causality, type, unit and start value."""

    causality: str
    type: str = "Real"
    unit: str = ""
    start: str = "0"


def library(folder: Path) -> Path:
    """Compile the one library of all stubs."""
    present = re.findall(r"\bfmi2\w+", SOURCE.read_text())
    present += [
        f"fmi2{verb}{kind}"
        for verb in ("Get", "Set")
        for kind in ("Real", "Integer", "Boolean")
    ]
    return compile_source(2, SOURCE, folder, present, {})


def stub(
    compiled: Path,
    file: Path,
    variables: Mapping[str, Stub],
    *,
    step: str = "",
    interface: str = "CoSimulation",
) -> Path:
    """Write an FMU; ``step`` is what it proposes for itself."""
    count: dict[tuple[str, str], int] = {}
    lines = []
    for name, v in variables.items():
        stored = "Integer" if v.type == "Enumeration" else v.type
        k = count.setdefault((v.causality, stored), 0)
        count[v.causality, stored] += 1
        start = "false" if v.type == "Boolean" and v.start == "0" else v.start
        given = v.causality in ("input", "parameter")
        own = f' start="{start}"' if given else ""
        own += f' unit="{v.unit}"' if v.unit else ""
        own += ' declaredType="Mode"' if v.type == "Enumeration" else ""
        is_parameter = v.causality.lower().endswith("parameter")
        of_parameter = ' variability="fixed"' if is_parameter else ""
        discrete = ' variability="discrete"' if v.type != "Real" else ""
        lines.append(
            f'<ScalarVariable name="{name}" valueReference="{FIRST[v.causality] + k}" '
            f'causality="{v.causality}"{of_parameter or discrete}>'
            f"<{v.type}{own}/></ScalarVariable>"
        )
    numbered = list(enumerate(variables.values(), 1))
    outputs = [i for i, v in numbered if v.causality == "output"]
    unknowns = "".join(f'<Unknown index="{i}" dependencies=""/>' for i in outputs)
    units = "".join(
        f'<Unit name="{u}"><BaseUnit {BASES[u]}/></Unit>'
        for u in dict.fromkeys(v.unit for v in variables.values() if v.unit in BASES)
    )
    of_units = f"<UnitDefinitions>{units}</UnitDefinitions>" if units else ""
    of_types = (
        '<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="off" '
        'value="1"/><Item name="on" value="4"/></Enumeration></SimpleType>'
        "</TypeDefinitions>"
    )
    experiment = f'<DefaultExperiment stepSize="{step}"/>' if step else ""
    tags = ("Outputs", "InitialUnknowns")
    structure = "".join(f"<{tag}>{unknowns}</{tag}>" for tag in tags if unknowns)
    description = (
        f'<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" guid="x" '
        f'modelName="stub"><{interface} modelIdentifier="{compiled.stem}" '
        f'canHandleVariableCommunicationStepSize="true"/>'.replace(
            ' canHandleVariableCommunicationStepSize="true"',
            ""
            if interface == "ModelExchange"
            else ' canHandleVariableCommunicationStepSize="true"',
        )
        + f"{of_units}{of_types}{experiment}"
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
    file.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(compiled, f"binaries/{fmpy.platform}/{compiled.name}")
    return file
