"""Declared types, ambiguous descriptions, structural parameters, experiments."""

import zipfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

import pytest
from broken import SOURCES
from foreign import compile_source, foreign, packed
from lxml import etree
from rewritten import rewritten
from typed import typed

from fmus.build import build
from orchestrator.errors import FmuError, WiringError
from orchestrator.fmu.declared import Item
from orchestrator.fmu.description import FmuVariable, read_fmu
from orchestrator.fmu.start_values import start_values
from orchestrator.master.simulate import plan, simulate
from orchestrator.system import Component, System

TYPES = {
    2: '<SimpleType name="T"><{kind} {of_type}>{items}</{kind}></SimpleType>',
    3: '<{kind}Type name="T" {of_type}>{items}</{kind}Type>',
}
VARIABLES = {
    2: '<ScalarVariable name="{name}" valueReference="{vr}" causality="parameter" '
    'variability="fixed"><{kind} declaredType="T" {own}/></ScalarVariable>',
    3: '<{kind} name="{name}" valueReference="{vr}" causality="parameter" '
    'variability="fixed" declaredType="T" {own}>{inside}</{kind}>',
}


def described(
    folder: Path,
    fmi: int,
    kind: str = "",
    of_type: str = "",
    own: str = 'start="1"',
    *,
    names: tuple[str, ...] = ("k",),
    first: str = "0",
    items: str = "",
    inside: str = "",
    identifier: str = "x",
    interface: str = "",
    more: str = "",
) -> Path:
    """Write an FMU that is a description alone."""
    kind = kind or ("Real" if fmi == 2 else "Float64")
    lines = "".join(
        VARIABLES[fmi].format(
            kind=kind, name=name, vr=first if i == 0 else i + 1, own=own, inside=inside
        )
        for i, name in enumerate(names)
    )
    type_ = TYPES[fmi].format(kind=kind, of_type=of_type, items=items)
    token = "guid" if fmi == 2 else "instantiationToken"
    text = (
        f'<?xml version="1.0"?><fmiModelDescription fmiVersion="{fmi}.0" {token}="x" '
        f'modelName="x"><CoSimulation modelIdentifier="{identifier}" {interface}/>'
        f"<TypeDefinitions>{type_}</TypeDefinitions>{more}"
        f"<ModelVariables>{lines}</ModelVariables><ModelStructure/>"
        f"</fmiModelDescription>"
    )
    fmu = folder / "x.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", text)
    return fmu


def variable(fmu: Path) -> FmuVariable:
    return read_fmu(fmu).variables["k"]


@pytest.mark.parametrize("fmi", [2, 3])
def test_attributes_of_the_declared_type_hold_unless_the_variable_has_its_own(
    tmp_path: Path, fmi: int
) -> None:
    of_type = 'min="-1" max="5" nominal="3" quantity="Torque" relativeQuantity="true"'
    k = variable(described(tmp_path, fmi, of_type=of_type))
    assert (k.min, k.max) == ("-1", "5")
    assert (k.declared.nominal, k.declared.quantity) == ("3", "Torque")
    assert k.declared.relative
    (tmp_path / "own").mkdir()
    own = 'start="1" max="7" relativeQuantity="false"'
    k = variable(described(tmp_path / "own", fmi, of_type=of_type, own=own))
    assert (k.min, k.max, k.declared.relative) == ("-1", "7", False)


@pytest.mark.parametrize("kind", ["Int8", "UInt8", "UInt64", "Float32"])
def test_bounds_of_every_type_are_kept(tmp_path: Path, kind: str) -> None:
    fmu = described(tmp_path, 3, kind, 'max="5"')
    component = Component("a", fmu, Fraction(1), parameters={"k": 6})
    with pytest.raises(WiringError, match="allows at most 5"):
        start_values(component, read_fmu(fmu))


@pytest.mark.parametrize("kind", ["Float64", "Float32"])
@pytest.mark.parametrize("bound", ["0.3", "3.141592653589793", "5"])
def test_a_value_on_its_bound_is_taken(tmp_path: Path, kind: str, bound: str) -> None:
    fmu = described(tmp_path, 3, kind, f'max="{bound}"')
    component = Component("a", fmu, Fraction(1), parameters={"k": float(bound)})
    start_values(component, read_fmu(fmu))


@pytest.mark.parametrize("fmi", [2, 3])
def test_items_of_an_enumeration_have_name_and_value(tmp_path: Path, fmi: int) -> None:
    items = '<Item name="off" value="1"/><Item name="on" value="4"/>'
    k = variable(described(tmp_path, fmi, "Enumeration", items=items))
    assert k.declared.items == (Item("off", 1), Item("on", 4))


AMBIGUOUS = {
    "reference of 2^32": (2, {"first": "4294967296"}, "valueReference '4294967296'"),
    "negative reference": (3, {"first": "-1"}, "valueReference '-1'"),
    "name twice": (3, {"names": ("k", "k")}, "two variables have the name 'k'"),
    "no name": (3, {"names": ("", "k")}, "of ModelVariables has no name"),
    "path": (2, {"identifier": "../x"}, "modelIdentifier '../x' is a path"),
    "alias without a name": (3, {"inside": "<Alias/>"}, "an? Alias of ModelVariables"),
    "alias of another's name": (
        3,
        {"names": ("k", "l"), "inside": '<Alias name="l"/>'},
        "two variables have the name",
    ),
    "no size": (3, {"inside": '<Dimension start="0"/>'}, "a dimension of 0"),
    "negative size": (3, {"inside": '<Dimension start="-2"/>'}, "dimension of -2"),
}


@pytest.mark.parametrize("case", AMBIGUOUS)
def test_what_makes_a_value_ambiguous_is_refused_when_read(
    tmp_path: Path, case: str
) -> None:
    fmi, changed, said = AMBIGUOUS[case]
    fmu = described(tmp_path, fmi, **changed)  # type: ignore[arg-type]
    with pytest.raises(FmuError, match=said):
        read_fmu(fmu)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_two_model_descriptions_are_refused(tmp_path: Path) -> None:
    fmu = described(tmp_path, 2)
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    with pytest.raises(FmuError, match="several files modelDescription"):
        read_fmu(fmu)


def test_what_an_experiment_does_otherwise_is_warned_of(tmp_path: Path) -> None:
    more = '<DefaultExperiment startTime="5" stepSize="0.004"/>'
    fmu = described(tmp_path, 2, more=more)
    for step, said in (("1/100", 2), ("1/250", 1), ("1/125", 1)):
        component = Component("a", fmu, Fraction(step))
        system = System("x", Fraction(1), {"a": component}, {}, {})
        warnings = plan(system).wiring.warnings
        assert len(warnings) == said, warnings


def structural(folder: Path) -> Path:
    library = compile_source(3, SOURCES / "structural.c", folder, (), {})
    size = '<Dimension valueReference="0"/>'
    text = (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="3.0" '
        'instantiationToken="x" modelName="x"><CoSimulation '
        'modelIdentifier="structural" canHandleVariableCommunicationStepSize="true"/>'
        '<ModelVariables><UInt64 name="n" valueReference="0" variability="fixed" '
        'causality="structuralParameter" start="2" max="100"/>'
        '<Float64 name="v" valueReference="1" causality="input" start="1 1">'
        f'{size}</Float64><Float64 name="sum" valueReference="2" causality="output"/>'
        '</ModelVariables><ModelStructure><Output valueReference="2"/>'
        '<InitialUnknown valueReference="2"/></ModelStructure></fmiModelDescription>'
    )
    return packed(3, folder, library, text)


@pytest.mark.parametrize("executor", ["kernel", "python"])
def test_a_structural_parameter_sets_the_size_of_arrays_before_all_else(
    tmp_path: Path, executor: str
) -> None:
    fmu = structural(tmp_path)
    given = {"v": (1.0, 2.0, 3.0, 4.0, 5.0), "n": 5}
    component = Component("a", fmu, Fraction(1, 10), start=given)
    record = {"a.sum": (Fraction(1, 10),), "a.n": (Fraction(1, 10),)}
    system = System("x", Fraction(1), {"a": component}, {}, record)
    found = simulate(system, tmp_path, executor=executor)  # type: ignore[arg-type]
    assert found["a.sum"].values[-1] == 15
    assert found["a.n"].values[-1] == 5


@pytest.mark.parametrize("n", [0, 2.5, True, 101])
def test_a_size_that_is_none_is_refused(tmp_path: Path, n: float) -> None:
    component = Component("a", structural(tmp_path), Fraction(1), parameters={"n": n})
    with pytest.raises(WiringError, match=r"parameters\.n = "):
        plan(System("x", Fraction(1), {"a": component}, {}, {}))


def test_of_an_array_of_a_new_size_all_values_are_to_be_given(tmp_path: Path) -> None:
    given = {"n": 5, "v[2]": 1.0}
    component = Component("a", structural(tmp_path), Fraction(1), start=given)
    with pytest.raises(WiringError, match="give all of them"):
        plan(System("x", Fraction(1), {"a": component}, {}, {}))


def commented(root: Any) -> None:
    """Put a comment and a processing instruction before every element."""
    for element in list(root.iter(etree.Element)):
        if element.getparent() is not None:
            element.addprevious(etree.Comment("no 1"))
            element.addprevious(etree.ProcessingInstruction("x", "y"))


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("kind", ["foreign", "typed", "plants.ball_screw.drive"])
def test_comments_change_nothing_wherever_they_stand(
    tmp_path: Path, fmi: Literal[2, 3], kind: str
) -> None:
    makers = {"foreign": foreign, "typed": typed}
    fmu = makers[kind](fmi, tmp_path) if kind in makers else build(kind, fmi=fmi)
    other = read_fmu(rewritten(fmu, tmp_path, commented))
    assert replace(other, path=fmu) == read_fmu(fmu)


def test_comments_do_not_hide_what_a_declared_type_says(tmp_path: Path) -> None:
    of_type = 'max="2" unit="K" relativeQuantity="true"'
    fmu = described(tmp_path, 2, of_type=of_type)
    k = variable(rewritten(fmu, tmp_path, commented))
    assert (k.declared.max, k.declared.relative, str(k.unit)) == ("2", True, "K")


def test_an_alias_is_read_as_what_it_is_of_and_never_set(tmp_path: Path) -> None:
    """It is no output, so that it makes nothing depend on more than it does."""

    def edit(root: Any) -> None:
        out = root.find("ModelVariables/*[@name='out_Float64']")
        etree.SubElement(out, "Alias", name="seen")
        gain = root.find("ModelVariables/*[@name='h']")
        etree.SubElement(gain, "Alias", name="other_h")

    fmu = rewritten(foreign(3, tmp_path), tmp_path, edit)
    assert "seen" not in read_fmu(fmu).outputs
    a = Component("a", fmu, Fraction(1), start={"in_Float64": 3.0})
    rows = {name: (Fraction(1),) for name in ("a.seen", "a.out_Float64")}
    found = simulate(System("x", Fraction(2), {"a": a}, {}, rows), tmp_path)
    assert list(found["a.seen"].values) == list(found["a.out_Float64"].values)
    assert found["a.seen"].values[-1] == 3
    with pytest.raises(WiringError, match="cannot be set"):
        start_values(replace(a, parameters={"other_h": 1.0}), read_fmu(fmu))
