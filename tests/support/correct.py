"""A correct FMU that bears nothing which the standard forbids (correct.c)."""

from pathlib import Path

from foreign import compile_source, configured, packed, whole

SOURCE = Path(__file__).with_name("correct.c")
KINDS = (
    *("plain", "ends", "unstable", "chaotic", "wants a stop time"),
    *("never returns", "waits", "loses a step", "steps alike"),
)


_LIBRARIES: dict[tuple[int, str, int], Path] = {}  # compiled once in a session


def correct(
    fmi: int, folder: Path, kind: str = "plain", *, variable_step: bool = True
) -> Path:
    """Build the FMU of one of ``KINDS`` into a folder and return its path."""
    place = folder / kind.replace(" ", "_")
    place.mkdir(parents=True, exist_ok=True)
    library = _compiled(fmi, kind, 0, place)
    return packed(fmi, place, library, describe(fmi, variable_step))


def large(folder: Path, parameters: int, locals_: int) -> Path:
    """Build one (FMI 2) with many parameters, and names of y besides."""
    library = _compiled(2, "plain", parameters, folder)
    more = [
        f'<ScalarVariable name="drive[{i}].p" valueReference="{100 + i}" '
        f'causality="parameter" variability="fixed"><Real unit="1" start="0"/>'
        f"</ScalarVariable>"
        for i in range(parameters)
    ]
    more += [
        f'<ScalarVariable name="drive[{i}].x" valueReference="1" causality="local" '
        f'variability="continuous" initial="calculated"><Real unit="1"/>'
        f"</ScalarVariable>"
        for i in range(locals_)
    ]
    text = describe(2).replace(
        "</ModelVariables>", "\n".join([*more, "</ModelVariables>"])
    )
    return packed(2, folder, library, text)


def defined(kind: str, more: int = 0) -> dict[str, int]:
    """Return what config.h defines."""
    return {"KIND": KINDS.index(kind), "MORE": more}


def _compiled(fmi: int, kind: str, more: int, folder: Path) -> Path:
    key = (fmi, kind, more)
    if key not in _LIBRARIES:
        _LIBRARIES[key] = compile_source(fmi, SOURCE, folder, (), defined(kind, more))
    return _LIBRARIES[key]


def source_of(fmi: int, kind: str = "plain") -> dict[str, str]:
    """Return its sources by name."""
    config = configured(fmi, SOURCE, (), defined(kind))
    return {"config.h": config, "correct.c": whole(SOURCE)}


def describe(fmi: int, variable_step: bool = True) -> str:
    """Return the model description, with everything that advice may ask for."""
    told = (
        'description="a lag" author="nobody" version="1" copyright="none" '
        'license="none" generationDateAndTime="2026-11-28T00:00:00Z"'
    )
    steps = str(variable_step).lower()
    simulation = (
        f'<CoSimulation modelIdentifier="correct" '
        f'canHandleVariableCommunicationStepSize="{steps}"/>'
        '<UnitDefinitions><Unit name="1"><BaseUnit/></Unit></UnitDefinitions>'
        '<LogCategories><Category name="logStatusError"/></LogCategories>'
        '<DefaultExperiment stopTime="1" stepSize="0.001"/>'
    )
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x"'
        variables = """
<ScalarVariable name="u" valueReference="0" causality="input"
  variability="continuous"><Real unit="1" start="1"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"
  variability="continuous" initial="calculated"><Real unit="1"/></ScalarVariable>
<ScalarVariable name="a" valueReference="2" causality="parameter"
  variability="fixed"><Real unit="1" start="1"/></ScalarVariable>"""
        structure = (
            '<Outputs><Unknown index="2" dependencies=""/></Outputs>'
            '<InitialUnknowns><Unknown index="2" dependencies=""/></InitialUnknowns>'
        )
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        size = '<Dimension valueReference="4"/>'
        variables = f"""
<Float64 name="u" valueReference="0" causality="input" unit="1" start="1"/>
<Float64 name="y" valueReference="1" causality="output" unit="1"/>
<Float64 name="a" valueReference="2" causality="parameter" variability="fixed"
  unit="1" start="1 2 3">{size}</Float64>
<Float64 name="s" valueReference="3" causality="output" unit="1">{size}</Float64>
<UInt64 name="n" valueReference="4" causality="structuralParameter"
  variability="fixed" start="3"/>
<Binary name="b" valueReference="5" causality="parameter" variability="fixed">
  <Start value="0a1b"/></Binary>
<Float64 name="time" valueReference="6" causality="independent"
  variability="continuous"/>"""
        structure = (
            '<Output valueReference="1" dependencies=""/>'
            '<Output valueReference="3" dependencies="0"/>'
            '<InitialUnknown valueReference="1" dependencies=""/>'
            '<InitialUnknown valueReference="3" dependencies="0 2"/>'
        )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {head} {told} '
        f'modelName="correct" variableNamingConvention="structured">{simulation}'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
