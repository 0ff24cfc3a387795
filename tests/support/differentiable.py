"""An FMU with partial derivatives, and a fault in them on demand (differentiable.c)."""

from pathlib import Path

from foreign import compile_source, packed

SOURCE = Path(__file__).with_name("differentiable.c")


def differentiable(fmi: int, folder: Path, *, fault: int = 0, shows: int = 1) -> Path:
    """Build the FMU; unless it ``shows`` inputs at once its outputs wait for steps."""
    defined = {"FAULT": fault, "OUTPUTS": shows}
    library = compile_source(fmi, SOURCE, folder, (), defined)
    return packed(fmi, folder, library, describe2() if fmi == 2 else describe3())


def describe2() -> str:
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{vr}" causality="{cause}">'
        f"<Real{start}/></ScalarVariable>"
        for name, vr, cause, start in (
            ("a", 0, "input", ' start="1"'),
            ("b_1", 1, "input", ' start="2"'),
            ("b_2", 2, "input", ' start="3"'),
            ("y", 4, "output", ""),
            ("z_1", 5, "output", ""),
            ("z_2", 6, "output", ""),
        )
    )
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in (4, 5, 6))
    structure = "".join(
        f"<{tag}>{unknowns}</{tag}>" for tag in ("Outputs", "InitialUnknowns")
    )
    return (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" guid="x" '
        'modelName="differentiable"><CoSimulation modelIdentifier="differentiable" '
        'providesDirectionalDerivative="true" maxOutputDerivativeOrder="1" '
        'canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def describe3() -> str:
    variables = (
        '<Float64 name="a" valueReference="0" causality="input" start="1"/>'
        '<Float64 name="b" valueReference="1" causality="input" start="2 3">'
        '<Dimension start="2"/></Float64>'
        '<Float64 name="x" valueReference="3" start="1" initial="exact"/>'
        '<Float64 name="y" valueReference="4" causality="output"/>'
        '<Float64 name="z" valueReference="5" causality="output">'
        '<Dimension start="2"/></Float64>'
        '<Float64 name="der(x)" valueReference="7" derivative="3"/>'
    )
    structure = "".join(
        f'<{tag} valueReference="{vr}"/>'
        for tag, vr in (
            ("Output", 4),
            ("Output", 5),
            ("ContinuousStateDerivative", 7),
            ("InitialUnknown", 4),
            ("InitialUnknown", 5),
            ("InitialUnknown", 7),
        )
    )
    flags = 'providesDirectionalDerivatives="true" providesAdjointDerivatives="true"'
    interfaces = "".join(
        f'<{tag} modelIdentifier="differentiable" {flags}{more}/>'
        for tag, more in (
            ("ModelExchange", ""),
            ("CoSimulation", ' maxOutputDerivativeOrder="1"'),
        )
    )
    return (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="3.0" '
        f'instantiationToken="x" modelName="differentiable">{interfaces}'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
