"""One unit per signal: connection, map, metric, expectation, comparison agree."""

import tomllib
import zipfile
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fmus.units import BaseUnit, TurnError, UnitError, base_unit
from orchestrator.errors import WiringError
from orchestrator.evaluation.compare import change
from orchestrator.evaluation.expectation import check
from orchestrator.evaluation.metrics import evaluate
from orchestrator.evaluation.schema import ErrorMetric, Expectation, PlainMetric
from orchestrator.fmu.declared import Declared
from orchestrator.fmu.description import FmuVariable, read_fmu
from orchestrator.fmu.ports import connection, ports
from orchestrator.master.wiring import wire
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import Unit, UnitNames, conversion, unit_of_fmu
from orchestrator.result import Signal
from orchestrator.system import Component, Mapped, System

NOT_RAD = ("kg", "m", "s", "A", "K", "mol", "cd")
EPS = np.finfo(float).eps

exponents = st.fixed_dictionaries({name: st.integers(-3, 3) for name in NOT_RAD})
factors = st.floats(1e-9, 1e9)
offsets = st.one_of(st.just(0.0), st.floats(-1e4, 1e4))
numbers = st.floats(-1e6, 1e6)


@st.composite
def pairs(draw):
    """Two units that foreign FMUs define for one quantity, by names of their own."""
    shared, rad = draw(exponents), draw(st.integers(-1, 1))
    return tuple(
        unit_of_fmu(
            name,
            BaseUnit(**shared, rad=rad, factor=draw(factors), offset=draw(offsets)),
            relative=draw(st.booleans()),
        )
        for name in ("theirs", "ours")
    )


def exact(source: Unit, sink: Unit, value: float) -> Fraction:
    """Return the value in the sink's unit by the standard's own rule."""
    assert source.base
    assert sink.base
    factor, offset = Fraction(repr(source.base.factor)), source.base.offset
    offsets = Fraction(repr(offset)) - Fraction(repr(sink.base.offset))
    if source.relative or sink.relative:
        offsets = Fraction(0)
    return (factor * Fraction(value) + offsets) / Fraction(repr(sink.base.factor))


def near(source: Unit, sink: Unit, value: float) -> pytest.approx:
    """Return the exact value within the rounding of one gain and one offset."""
    gain, offset, _ = conversion(source, sink)
    size = abs(gain * value) + abs(offset)
    return pytest.approx(float(exact(source, sink, value)), abs=4 * EPS * size, rel=0)


DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
<CoSimulation modelIdentifier="m" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables/><ModelStructure/></fmiModelDescription>"""


@pytest.fixture(scope="module")
def fmu_of(tmp_path_factory):
    """Return a function: component and FMU with one variable of a unit."""
    file = tmp_path_factory.mktemp("fmu") / "m.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
    component, plain = Component("c", file, Fraction(1, 1000)), read_fmu(file)

    def made(unit, causality="output", name="x", **options):
        variable = FmuVariable(
            **{"name": name, "fmi_type": "Real", "reference": 0, "shape": ()},
            **{"causality": causality, "variability": "continuous", "initial": None},
            **{"unit": unit, "base_unit": unit and unit.base, "start": "0"},
            **{"min": None, "max": None, "description": "", "declared": Declared()},
        )
        units = {str(unit): unit.base} if unit and unit.base else {}
        fmu = replace(plain, variables={name: variable}, units=units)
        return replace(component, **options), fmu

    return made


@given(pairs(), numbers)
def test_every_place_converts_as_exact_arithmetic_does(fmu_of, pair, value):
    source, sink = pair
    wanted = near(source, sink, value)
    (out,) = ports(*fmu_of(source), "x")
    (into,) = ports(*fmu_of(sink, "input"), "x")
    gain, offset = (affine := connection(out, into).affine).gain, affine.offset
    assert gain * value + offset == wanted

    mapped = {"y": Mapped("x", unit=sink)}
    (ours,) = ports(*fmu_of(source, map=mapped), "y")
    assert (ours.unit, ours.unit.base) == (sink, sink.base)

    signal = Signal("c.x", np.array([0.0]), np.array([value]), source)
    metric = PlainMetric(of="c.x", kind="final").model_copy(update={"unit": sink})
    figure = evaluate({"m": metric}, {"c.x": signal}, Quantity)["m.final"]
    beside = Quantity(value, source).to(sink)
    same = sink.of_difference(source.relative)
    assert figure.value == beside.value == near(source, same, value)
    assert ours.to_ours.gain * value + ours.to_ours.offset == figure.value

    bound = Expectation(near=figure.value, within=1e-300)
    bound = bound.model_copy(update={"unit": sink})
    assert check({"m.final": bound}, {"m.final": beside})[0].met
    assert change("m.final", {"m.final": beside}, {"m.final": figure}) in (
        "",
        "+0.00 %",
    )


@given(pairs(), numbers, numbers)
def test_a_difference_takes_no_offset(pair, one, other):
    source, sink = (unit.of_difference(False) for unit in pair)
    signals = {
        name: Signal(name, np.array([0.0]), np.array([value]), source)
        for name, value in (("c.x", one), ("c.y", other))
    }
    metric = ErrorMetric(of="c.x", against="c.y", kind="error")
    error = evaluate({"e": metric}, signals, Quantity)["e.mean"]
    gain = conversion(source, sink).gain
    assert error.to(sink).value == gain * (other - one)


def test_a_difference_of_10_degrees_is_10_kelvin():
    degrees = unit_of_fmu("degC", base_unit("degC"), relative=True)
    assert Quantity(10.0, degrees).to("K") == Quantity(10.0, "K")
    assert Quantity(10.0, "degC").to("K").value == 283.15


@given(factors, factors, st.booleans())
def test_a_frequency_never_becomes_an_angular_one_unasked(fmu_of, one, two, turned):
    """60 Hz into rad/s, 60 1/min into rad/s: 2 pi or not is not ours to guess."""
    units = [
        Unit("a", BaseUnit(s=-1, factor=one)),
        Unit("b", BaseUnit(s=-1, rad=1, factor=two)),
    ]
    source, sink = units[:: -1 if turned else 1]
    with pytest.raises(TurnError):
        conversion(source, sink)
    (out,) = ports(*fmu_of(source), "x")
    (into,) = ports(*fmu_of(sink, "input"), "x")
    with pytest.raises(WiringError, match=r"counts turns, write\n\n\[components.c.map"):
        connection(out, into)


@pytest.mark.parametrize(("there", "here"), [("Hz", "rad/s"), ("1/min", "deg/s")])
@pytest.mark.parametrize("inward", [True, False])
def test_the_map_to_paste_passes_and_counts_turns(fmu_of, there, here, inward):
    theirs, ours = (Unit(name, base_unit(name)) for name in (there, here))
    ends = [
        ports(*fmu_of(unit, causality), "x")[0]
        for unit, causality in zip(
            (ours, theirs) if inward else (theirs, ours),
            ("output", "input"),
            strict=True,
        )
    ]
    with pytest.raises(WiringError) as refused:
        connection(*ends)
    pasted = str(refused.value).split("\n\n")[1]
    line = tomllib.loads(pasted)["components"]["c"]["map"]["x"]
    mapped, fmu = fmu_of(theirs, "input" if inward else "output")
    mapped = replace(mapped, map={"x": Mapped(**line)})
    ends[1 if inward else 0] = ports(mapped, fmu, "x")[0]
    affine = connection(*ends).affine
    turns = 2 * np.pi * theirs.base.factor / ours.base.factor
    assert affine.gain == pytest.approx(1 / turns if inward else turns, rel=1e-12)


@pytest.mark.parametrize(
    ("source", "sink"),
    [("N.m", "N.m/rad"), ("rad", "1"), ("1/s2", "rad/s2"), ("m", "m/rad")],
)
def test_any_other_difference_in_rad_is_told(source, sink):
    (doubt,) = conversion(source, sink).doubts
    assert "with the radian counted as 1" in doubt


def test_what_an_exporter_left_out_is_filled_in_and_told():
    undefined = unit_of_fmu("rpm", None)
    assert undefined.base == base_unit("rpm")
    assert "without defining it" in conversion(undefined, "rad/s").doubts[0]
    bare = unit_of_fmu("rad/s", BaseUnit(s=-1))
    gain, offset, doubts = conversion(bare, "deg/s")
    assert (gain, offset) == (pytest.approx(180 / np.pi), 0.0)
    assert "without the radian" in doubts[0]
    per_minute = unit_of_fmu("rpm", BaseUnit(s=-1, factor=1 / 60))
    assert per_minute.base.rad == 0  # turns per minute by its own definition


def test_one_name_is_one_unit_if_only_one_side_defines_it():
    turns = unit_of_fmu("rpm", BaseUnit(s=-1, factor=1 / 60))
    gain, offset, (doubt,) = conversion(turns, unit_of_fmu("rpm", None))
    assert (gain, offset) == (1.0, 0.0)
    assert "without defining it; taken as the other's" in doubt
    with pytest.raises(TurnError):
        conversion(turns, unit_of_fmu("rpm", BaseUnit(rad=1, s=-1, factor=0.1047)))


def test_a_unit_that_nobody_defines_passes_as_it_is_and_is_told(fmu_of):
    bits = unit_of_fmu("bits", None)
    (out,) = ports(*fmu_of(bits), "x")
    (into,) = ports(*fmu_of(Unit("m", base_unit("m")), "input"), "x")
    affine, _, doubts = connection(out, into)
    assert not affine.converts
    assert "connected as numbers, since bits cannot become m" in doubts[0]
    with pytest.raises(UnitError, match="bits cannot become m"):
        Quantity(1.0, bits).to("m")
    assert Quantity(1.0, bits).to("bits").value == 1.0


def test_a_map_with_a_unit_converts_or_is_refused(fmu_of):
    length = Unit("mm", base_unit("mm"))
    for causality, gain in (("output", 1e-3), ("input", 1e3), ("parameter", 1e3)):
        component, fmu = fmu_of(length, causality, map={"y": Mapped("x", unit="m")})
        (port,) = ports(component, fmu, "y")
        assert (port.gain, port.unit) == (gain, "m")
        assert port.to_ours.gain == pytest.approx(1e-3)
    for theirs, said in ((length, "mm cannot become rad"), (None, "no unit there")):
        component, fmu = fmu_of(theirs, map={"y": Mapped("x", unit="rad")})
        with pytest.raises(WiringError, match=f"{said}.*or give it a gain"):
            ports(component, fmu, "y")
    component, fmu = fmu_of(length, map={"y": Mapped("x", 0.314, unit="rad")})
    assert ports(component, fmu, "y")[0].gain == 0.314


def test_a_guess_in_the_map_of_what_is_written_is_told(fmu_of):
    component, fmu = fmu_of(unit_of_fmu("rpm", None), "parameter")
    component = replace(
        component, map={"y": Mapped("x", unit="rad/s")}, parameters={"y": 1.0}
    )
    system = System("s", Fraction(1), {"c": component}, {}, {})
    (warning,) = wire(system, {"c": fmu}).warnings
    assert "components.c.map: x: the FMU names the unit rpm" in warning


def test_names_mean_what_the_fmu_at_hand_says_then_another_then_our_table():
    inch, ell = BaseUnit(m=1, factor=0.0254), BaseUnit(m=1, factor=0.6)
    names = UnitNames({"a": {"ell": ell, "m": inch}, "b": {"ell": inch}, "c": {}})
    assert names.unit("ell", "a").base == ell
    assert names.unit("N/ell", "b").base == replace(base_unit("N/m"), factor=1 / 0.0254)
    assert names.unit("m", "c").base == inch
    assert names.unit("mm", "c").base == base_unit("mm")
    with pytest.raises(UnitError, match="ell is defined in different ways by a and b"):
        names.unit("ell", "c")


@given(pairs())
def test_result_files_keep_the_definition(pair):
    unit, _ = pair
    assume(unit.base is not None)
    stored = {k.encode(): v.encode() for k, v in unit.metadata().items()}
    read = Unit.from_metadata(stored)
    assert (read, read.base, read.relative) == (unit, unit.base, unit.relative)


UNITS = """<UnitDefinitions><Unit name="grd"><BaseUnit K="1" offset="273.15"/></Unit>
<Unit name="furlong"><BaseUnit m="1" factor="0"/></Unit></UnitDefinitions>"""
TYPES = {
    2: '<SimpleType name="T"><Real unit="grd" relativeQuantity="true"/></SimpleType>',
    3: '<Float64Type name="T" unit="grd" relativeQuantity="true"/>',
}
VARIABLE = {
    2: '<ScalarVariable name="{0}" valueReference="{1}"><Real {2}/></ScalarVariable>',
    3: '<Float64 name="{0}" valueReference="{1}" {2}/>',
}


@pytest.mark.parametrize("fmi", [2, 3])
def test_units_are_read_from_variable_and_type(fmi, tmp_path):
    """fmpy 0.3.32 never finds a variable's own relativeQuantity."""
    attributes = {
        "of_type": 'declaredType="T"',
        "not_so": 'declaredType="T" relativeQuantity="false"',
        "own": 'unit="grd" relativeQuantity="1"',
        "value": 'unit="grd"',
        "void": 'unit="furlong"',
        "bare": "",
    }
    variables = "".join(
        VARIABLE[fmi].format(name, i, text)
        for i, (name, text) in enumerate(attributes.items())
    )
    token = "guid" if fmi == 2 else "instantiationToken"
    text = (
        DESCRIPTION.replace('"2.0"', f'"{fmi}.0"')
        .replace("guid", token)
        .replace(
            "<ModelVariables/>",
            f"{UNITS}<TypeDefinitions>{TYPES[fmi]}"
            f"</TypeDefinitions><ModelVariables>{variables}</ModelVariables>",
        )
    )
    file = tmp_path / "m.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", text)
    found = {name: v.unit for name, v in read_fmu(file).variables.items()}
    relative = {name: unit.relative for name, unit in found.items() if unit}
    assert relative == {
        **{"of_type": True, "not_so": False, "own": True, "value": False},
        "void": False,
    }
    assert found["bare"] is None
    assert found["value"].base == BaseUnit(K=1, offset=273.15)
    assert "without defining it" in found["void"].doubt
