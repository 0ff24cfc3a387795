"""Drives in increments with the handshake of their profile (foreign_drive.c)."""

from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).with_name("foreign_drive.c")
WORDS = {
    402: {
        "Controlword": 0,
        "rpdo.Target_Position": 1,
        "6041h": 10,
        "Actual position": 11,
    },
    105: {
        "STW1": 0,
        "NSOLL_B": 1,
        "XERR": 2,
        "KPC": 3,
        "ZSW1": 10,
        "NIST_B": 11,
        "G1_XIST1": 12,
    },
}


def drive(mode: int, folder: Path) -> Path:
    """Build a drive of a profile into a folder and return its path."""
    place = folder / str(mode)
    place.mkdir(parents=True, exist_ok=True)
    library = compile_source(2, SOURCE, place, [], {"MODE": mode})
    lines = []
    for name, reference in WORDS[mode].items():
        cause = "input" if reference < 10 else "output"
        start = ' start="0"' if reference < 10 else ""
        lines.append(
            f'<ScalarVariable name="{name}" valueReference="{reference}" '
            f'causality="{cause}" variability="discrete"><Integer{start}/>'
            f"</ScalarVariable>"
        )
    lines += [
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="parameter" '
        f'variability="fixed"><Real start="{start}"/></ScalarVariable>'
        for i, (name, start) in enumerate({"gain": 100, "stands_at": 0}.items())
    ]
    listed = enumerate(WORDS[mode].values(), 1)
    unknowns = "".join(
        f'<Unknown index="{i}" dependencies=""/>' for i, r in listed if r >= 10
    )
    return packed(
        2,
        place,
        library,
        f'<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" guid="x" '
        f'modelName="drive"><CoSimulation modelIdentifier="{library.stem}"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>"
        f"<Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
        f"</ModelStructure></fmiModelDescription>",
    )
