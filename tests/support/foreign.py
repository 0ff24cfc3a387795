"""An FMU of no exporter: every type, and failures on demand (foreign.c)."""

import re
import zipfile
from collections.abc import Collection, Mapping
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

from fmus.compile import compile_alone, host_platform

SOURCE = Path(__file__).with_name("foreign.c")
TYPES = {
    2: ("Real", "Integer", "Boolean"),
    3: (
        "Float64",
        *("Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32"),
        *("Int64", "UInt64", "Boolean"),
    ),
}


def foreign(fmi: int, folder: Path) -> Path:
    """Build the FMU into a folder and return its path."""
    defined = {"TYPES": len(TYPES[fmi])}
    present = [
        f"fmi{fmi}{verb}{kind}" for kind in TYPES[fmi] for verb in ("Get", "Set")
    ]
    library = compile_source(fmi, SOURCE, folder, present, defined)
    return packed(fmi, folder, library, describe(fmi))


def compile_source(
    fmi: int,
    source: Path,
    folder: Path,
    present: Collection[str],
    defined: Mapping[str, int],
) -> Path:
    """Compile a source whose config.h names it the standard's functions."""
    config = configured(fmi, source, present, defined)
    sources = {"config.h": config, source.name: whole(source)}
    return compile_alone(source.stem, sources, host_platform(), folder / "libraries")


def whole(source: Path) -> str:
    """Return a C source with the files of its folder that it includes in it."""

    def content(line: re.Match[str]) -> str:
        file = source.with_name(line[1])
        return file.read_text() if file.is_file() else line[0]

    return re.sub(r'(?m)^#include "(.*)"$', content, source.read_text())


def configured(
    fmi: int, source: Path, present: Collection[str], defined: Mapping[str, int]
) -> str:
    """Return config.h: functions neither in the text nor ``present`` return Error."""
    text = whole(source)
    slaves = (FMU2Slave,) if fmi == 2 else (FMU3Slave, FMU3Model)
    renamed = {
        "ENTER": f"fmi{fmi}EnterInitializationMode",
        "EXIT": f"fmi{fmi}ExitInitializationMode",
        "TERMINATE": f"fmi{fmi}Terminate",
        "FREE": f"fmi{fmi}FreeInstance",
    }
    wanted = {n for slave in slaves for n in dir(slave) if n.startswith(f"fmi{fmi}")}
    there = {*present, *renamed.values(), *re.findall(r"\bfmi\d\w+", text)}
    config = [f"#define {a} {b}" for a, b in ({"FMI": fmi} | defined).items()]
    config += [f"#define {a} {b}" for a, b in renamed.items()]
    absent = sorted(wanted - there)
    stubs = " ".join(f"EXPORT int {name}(void) {{ return ERROR; }}" for name in absent)
    return "\n".join([*config, f"#define ABSENT {stubs}", ""])


def packed(fmi: int, folder: Path, library: Path, description: str) -> Path:
    """Write an FMU of a library and a model description; return its path."""
    place = fmpy.platform if fmi == 2 else fmpy.platform_tuple
    file = folder / f"{library.stem}{fmi}.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{place}/{library.name}")
    return file


def describe(fmi: int) -> str:
    """Return the model description."""
    variables, outputs = [], []
    for i, kind in enumerate(TYPES[fmi]):
        discrete = (
            "" if "Float" in kind or kind == "Real" else ' variability="discrete"'
        )
        start = 'start="false"' if kind == "Boolean" else 'start="0"'
        variables.append((f"in_{kind}", i, kind, "input", start + discrete, ""))
        variables.append((f"out_{kind}", 100 + i, kind, "output", discrete, ""))
        outputs.append(100 + i)
    real = TYPES[fmi][0]
    if fmi == 3:
        two = '<Dimension start="2"/>'
        variables.append(("in_two", 20, real, "input", 'start="0 0"', two))
        variables.append(("out_two", 120, real, "output", "", two))
        outputs.append(120)
    for i, name in enumerate(("steps", "length")):
        variables.append((name, 130 + i, real, "output", "", ""))
        outputs.append(130 + i)
    fixed = 'start="0"' + ' variability="fixed"'
    variables += [(n, 50 + i, real, "parameter", fixed, "") for i, n in enumerate("ha")]
    if fmi == 2:
        lines = [
            f'<ScalarVariable name="{name}" valueReference="{vr}" causality="{cause}"'
            f"{' variability' + rest.partition(' variability')[2]}>".replace(
                " variability>", ">"
            )
            + f"<{kind} {rest.partition(' variability')[0]}/></ScalarVariable>"
            for name, vr, kind, cause, rest, _ in variables
        ]
        index = {vr: i + 1 for i, (_, vr, *_) in enumerate(variables)}
        unknowns = "".join(f'<Unknown index="{index[vr]}"/>' for vr in outputs)
        tags = ("Outputs", "InitialUnknowns")
        structure = "".join(f"<{tag}>{unknowns}</{tag}>" for tag in tags)
        head = 'fmiVersion="2.0" guid="x"'
    else:
        lines = [
            f'<{kind} name="{name}" valueReference="{vr}" causality="{cause}" {rest}>'
            f"{inside}</{kind}>"
            for name, vr, kind, cause, rest, inside in variables
        ]
        structure = "".join(
            f'<{tag} valueReference="{vr}"/>'
            for tag in ("Output", "InitialUnknown")
            for vr in outputs
        )
        head = 'fmiVersion="3.0" instantiationToken="x"'
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="foreign">'
        f'<CoSimulation modelIdentifier="foreign" '
        f'canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
