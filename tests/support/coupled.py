"""FMUs that feed through in a circle, with a state to come back to (coupled.c)."""

from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).with_name("coupled.c")


OFFERS = (
    'providesIntermediateUpdate="true" mightReturnEarlyFromDoStep="true" '
    'canReturnEarlyAfterIntermediateUpdate="true"'
)


def coupled(
    fmi: int,
    folder: Path,
    *,
    states: bool = True,
    interface: str = "",
    kind: str = "CoSimulation",
) -> Path:
    """Build the FMU into a folder; without ``states`` it says it has none.

    ``interface`` are further attributes of its interface, which is of a ``kind``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    library = compile_source(fmi, SOURCE, folder, (), {})
    return packed(fmi, folder, library, _description(fmi, states, interface, kind))


def _description(fmi: int, states: bool, further: str, kind: str) -> str:
    rows = [
        ("u", "input", 'start="0"', ""),
        ("a", "parameter", 'start="0"', ' variability="fixed"'),
        ("b", "parameter", 'start="0"', ' variability="fixed"'),
        ("y", "output", "", ""),
        ("n", "output", "", ""),
    ]
    word = "FMUstate" if fmi == 2 else "FMUState"
    can = f'canGetAndSet{word}="{str(states).lower()}"'
    interface = (
        f'<{kind} modelIdentifier="coupled" {can} {further} '
        f'canHandleVariableCommunicationStepSize="true"/>'
    )
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x"'
        lines = [
            f'<ScalarVariable name="{name}" valueReference="{i}" causality="{cause}"'
            f"{of}><Real {start}/></ScalarVariable>"
            for i, (name, cause, start, of) in enumerate(rows)
        ]
        unknowns = '<Unknown index="4"/><Unknown index="5" dependencies=""/>'
        structure = "".join(
            f"<{tag}>{unknowns}</{tag}>" for tag in ("Outputs", "InitialUnknowns")
        )
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        lines = [
            f'<Float64 name="{name}" valueReference="{i}" causality="{cause}" '
            f"{start}{of}/>"
            for i, (name, cause, start, of) in enumerate(rows)
        ]
        structure = "".join(
            f'<{tag} valueReference="3"/><{tag} valueReference="4" dependencies=""/>'
            for tag in ("Output", "InitialUnknown")
        )
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="coupled">'
        f"{interface}<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
