"""FMUs that end runs, lose what is set, and talk (broken/outcomes.c)."""

from pathlib import Path

from broken import SOURCES
from foreign import compile_source, packed

NAMES = {
    "t": 'causality="output"',
    "how": 'causality="parameter" variability="fixed" start="0"',
    "at": 'causality="parameter" variability="fixed" start="1"',
    "k": 'causality="parameter" variability="fixed" start="1"',
    "seen": 'causality="output"',
    "u": 'causality="input" start="0"',
}


def outcomes(
    fmi: int, folder: Path, *, loses: int = 0, needs_stop: int = 0, talks: int = 0
) -> Path:
    """Build one into a folder and return its path."""
    defined = {"LOSES": loses, "NEEDS_STOP": needs_stop, "TALKS": talks}
    place = folder / f"outcomes_{fmi}_{loses}{needs_stop}{talks}"
    place.mkdir(exist_ok=True)
    library = compile_source(fmi, SOURCES / "outcomes.c", place, (), defined)
    return packed(fmi, place, library, _description(fmi))


def _description(fmi: int) -> str:
    lines = []
    for i, (name, about) in enumerate(NAMES.items()):
        head = f'name="{name}" valueReference="{i}"'
        if fmi == 3:
            lines.append(f"<Float64 {head} {about}/>")
            continue
        about, _, start = about.partition(" start")
        real = f"<Real start{start}/>" if start else "<Real/>"
        lines.append(f"<ScalarVariable {head} {about}>{real}</ScalarVariable>")
    outputs = [i for i, about in enumerate(NAMES.values()) if "output" in about]
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x"'
        unknowns = "".join(f'<Unknown index="{i + 1}"/>' for i in outputs)
        structure = f"<Outputs>{unknowns}</Outputs>"
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        structure = "".join(f'<Output valueReference="{i}"/>' for i in outputs)
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="Outcomes">'
        f'<CoSimulation modelIdentifier="outcomes" '
        f'canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
