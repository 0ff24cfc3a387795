"""FMUs that hear and say texts and bytes (talking.c)."""

from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).with_name("talking.c")


def talking(fmi: int, folder: Path) -> Path:
    """Build the FMU into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    library = compile_source(fmi, SOURCE, folder, (), {})
    return packed(fmi, folder, library, _description(fmi))


def _description(fmi: int) -> str:
    interface = (
        '<CoSimulation modelIdentifier="talking" '
        'canHandleVariableCommunicationStepSize="true"/>'
    )
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x"'
        rows = [
            ("heard", "input", "String", 'start=""'),
            ("text", "output", "String", ""),
            ("k", "output", "Real", ""),
        ]
        places = {"heard": 0, "text": 1, "k": 4}
        lines = [
            f'<ScalarVariable name="{name}" valueReference="{places[name]}" '
            f'causality="{cause}" variability="discrete"><{kind} {start}/>'
            f"</ScalarVariable>"
            for name, cause, kind, start in rows
        ]
        unknowns = '<Unknown index="2" dependencies=""/><Unknown index="3"/>'
        structure = "".join(
            f"<{tag}>{unknowns}</{tag}>" for tag in ("Outputs", "InitialUnknowns")
        )
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        lines = [
            '<String name="heard" valueReference="0" causality="input">'
            '<Start value=""/></String>',
            '<String name="text" valueReference="1" causality="output"/>',
            '<Binary name="data" valueReference="2" causality="input">'
            '<Start value="00"/></Binary>',
            '<Binary name="bytes" valueReference="3" causality="output"/>',
            '<Float64 name="k" valueReference="4" causality="output"/>',
        ]
        structure = "".join(
            f'<{tag} valueReference="{i}" dependencies=""/>'
            for tag in ("Output", "InitialUnknown")
            for i in (1, 3, 4)
        )
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="talking">'
        f"{interface}<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
