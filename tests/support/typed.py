"""FMUs with a variable of every type in every role (types.c)."""

import re
from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).with_name("types.c")
TYPES = {
    2: ("Real", "Integer", "Boolean", "String", "Enumeration"),
    3: (
        *("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32"),
        *("Int64", "UInt64", "Boolean", "String", "Binary", "Enumeration", "Clock"),
    ),
}
ITEMS = {"off": 1, "slow": 2, "fast": 4}
_STARTS = {"Boolean": "false", "String": "", "Binary": "", "Enumeration": "1"}


def typed(fmi: int, folder: Path) -> Path:
    """Build the FMU into a folder and return its path."""
    named = re.findall(r"ACCESS\((\w+),", SOURCE.read_text())
    present = [f"fmi{fmi}{verb}{name}" for name in named for verb in ("Get", "Set")]
    library = compile_source(fmi, SOURCE, folder, present, {})
    return packed(fmi, folder, library, _description(fmi))


def _description(fmi: int) -> str:
    roles = {
        "in": (0, 'causality="input" variability="discrete"'),
        "p": (50, 'causality="parameter" variability="fixed"'),
        "out": (100, 'causality="output" variability="discrete"'),
    }
    lines = []
    for i, kind in enumerate(TYPES[fmi]):
        if kind == "Clock":
            lines.append(
                '<Clock name="in_Clock" valueReference="90" causality="input" '
                'intervalVariability="constant" intervalDecimal="0.01"/>'
            )
            continue
        for role, (first, about) in roles.items():
            head = f'name="{role}_{kind}" valueReference="{first + i}" {about}'
            start = "" if role == "out" else _STARTS.get(kind, "0")
            declared = 'declaredType="Mode"' if kind == "Enumeration" else ""
            lines.append(_variable(fmi, kind, head, start, role != "out", declared))
    outputs = [n for n, line in enumerate(lines, 1) if 'causality="output"' in line]
    items = "".join(f'<Item name="{n}" value="{v}"/>' for n, v in ITEMS.items())
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x"'
        unknowns = "".join(f'<Unknown index="{n}"/>' for n in outputs)
        tags = ("Outputs", "InitialUnknowns")
        structure = "".join(f"<{tag}>{unknowns}</{tag}>" for tag in tags)
        mode = (
            f'<SimpleType name="Mode"><Enumeration>{items}</Enumeration></SimpleType>'
        )
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        numbers = [100 + i for i, kind in enumerate(TYPES[3]) if kind != "Clock"]
        structure = "".join(
            f'<{tag} valueReference="{vr}"/>'
            for tag in ("Output", "InitialUnknown")
            for vr in numbers
        )
        mode = f'<EnumerationType name="Mode">{items}</EnumerationType>'
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="types">'
        f'<CoSimulation modelIdentifier="types" '
        f'canHandleVariableCommunicationStepSize="true"/>'
        f"<TypeDefinitions>{mode}</TypeDefinitions>"
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def _variable(
    fmi: int, kind: str, head: str, start: str, starts: bool, declared: str
) -> str:
    own = f'start="{start}"' if starts else ""
    if fmi == 2:
        inside = f"<{kind} {declared} {own}/>"
        return f"<ScalarVariable {head}>{inside}</ScalarVariable>"
    if kind in ("String", "Binary"):
        inside = f'<Start value="{start}"/>' if starts else ""
        return f"<{kind} {head}>{inside}</{kind}>"
    return f"<{kind} {head} {declared} {own}/>"
