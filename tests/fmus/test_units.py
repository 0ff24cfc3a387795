import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pint import UnitRegistry

from fmus import unit_names
from fmus.units import BaseUnit, TurnError, UnitError, base_unit, conversion

NAMES = ["N", "V", "m", "mm", "um", "s", "rad", "deg", "kg", "g", "A", "Hz", "percent"]
REGISTRY = UnitRegistry()
PINTS_BASES = (
    "gram",
    "meter",
    "second",
    "ampere",
    "kelvin",
    "mole",
    "candela",
    "radian",
)

factors = st.tuples(st.sampled_from(NAMES), st.integers(1, 3), st.sampled_from("./"))


@st.composite
def units(draw):
    """Units of our grammar with their meaning in pint's."""
    ours, pints = "1", "1"
    for name, exponent, operator in draw(st.lists(factors, max_size=4)):
        ours += f"{operator}{name}{exponent if exponent > 1 else ''}"
        pints += f"{'*' if operator == '.' else '/'}{name}**{exponent}"
    return ours, pints


@given(units())
def test_factor_and_exponents_are_those_of_pint(unit):
    ours, pints = unit
    root = REGISTRY.Quantity(1, pints).to_root_units()
    got = base_unit(ours)
    kilo = 1000.0**got.kg
    assert got.factor * kilo == pytest.approx(root.magnitude, rel=1e-12)
    exponents = {str(n): e for n, e in root.unit_items()}
    assert got.rad == exponents.get("radian", 0)
    assert got.kg == exponents.get("gram", 0)
    assert got.s == exponents.get("second", 0)


@given(units(), units())
def test_division_by_a_group_is_division_by_all_of_it(a, b):
    whole = base_unit(f"({a[0]})/({b[0]})")
    one, other = base_unit(a[0]), base_unit(b[0])
    assert whole.factor == pytest.approx(one.factor / other.factor, rel=1e-12)
    assert whole.m == one.m - other.m


@given(units(), st.floats(-1e6, 1e6))
def test_conversion_there_and_back_changes_nothing(unit, value):
    source = base_unit(unit[0])
    sink = BaseUnit(**source.exponents, factor=0.001, offset=7.0)
    gain, offset, _ = conversion(source, sink)
    back, back_offset, _ = conversion(sink, source)
    there = gain * value + offset
    returned = back * there + back_offset
    assert returned == pytest.approx(value, rel=1e-9, abs=1e-9 * abs(7 * back))


@pytest.mark.parametrize(
    ("source", "sink", "gain"),
    [
        ("mm", "um", 1000.0),
        ("um", "m", 1e-6),
        ("N/um", "N/m", 1e6),
        ("min", "s", 60.0),
        ("percent", "1", 0.01),
        ("rad", "deg", 57.29577951308232),
        ("kN", "N", 1000.0),
        ("Hz", "1/s", 1.0),
        ("g", "kg", 0.001),
        ("(rad/s2)/s", "rad/s3", 1.0),
        ("V/(rad/s2)", "V.s2/rad", 1.0),
    ],
)
def test_gain_is_exact_to_the_last_bit(source, sink, gain):
    assert conversion(base_unit(source), base_unit(sink)) == (gain, 0.0, False)


def test_slash_divides_by_the_next_factor_only():
    assert base_unit("V/rad.s2") == base_unit("V.s2/rad")


def test_a_temperature_has_an_offset():
    assert conversion(base_unit("degC"), base_unit("K")) == (1.0, 273.15, False)
    assert conversion(base_unit("K"), base_unit("degC")) == (1.0, -273.15, False)


def test_an_ignored_radian_is_reported():
    assert conversion(base_unit("N.m"), base_unit("N.m/rad")).ignored_rad


def test_a_frequency_is_no_angular_frequency():
    with pytest.raises(TurnError):
        conversion(base_unit("Hz"), base_unit("rad/s"))


def test_different_dimensions_are_refused():
    with pytest.raises(UnitError, match=r"kg.m.s-2 is not m"):
        conversion(base_unit("N"), base_unit("m"))


@pytest.mark.parametrize(
    "text", ["", "V.", "V..s", "(V", "V)", "dB", "bit", "degC.m", "degC2", "T_s"]
)
def test_what_is_no_unit_is_refused(text):
    with pytest.raises(UnitError, match="unit"):
        base_unit(text)


SPELLED = {
    "N.m": ["Nm", "N*m", "N m", "N-m", "N·m", "N⋅m", "newton.meter", "J"],
    "mN.m": ["mNm", "Nmm"],
    "N.m.s/rad": ["Nms/rad", "N*m*s/rad", "N.m/(rad/s)", "N.m.s.rad-1"],
    "m/s2": [
        "m/s^2",
        "m/s**2",
        "m/s²",
        "m.s-2",
        "m.s^-2",
        "m s⁻²",
        "m/s/s",
        "m*s^(-2)",
    ],
    "kg.m2": ["kgm2", "kgm^2", "kg*m^2", "kg m2", "kg·m²", "kg-m^2"],
    "rad.s-1": ["rad/s", "rad s-1", "radian/second", "Rad/sec"],
    "rev/min": [
        "rpm",
        "RPM",
        "U/min",
        "r/min",
        "turn/min",
        "revolution/minute",
        "revs/min",
    ],
    "1/min": ["min-1", "min^-1"],
    "ohm": ["Ohm", "Ω", "Ohms", "V/A", "OHM"],
    "kohm": ["kOhm", "kΩ"],
    "V.s/rad": ["Vs/rad", "V*s/rad", "Wb/rad"],
    "A.s": ["As", "C"],
    "1": ["-", "unitless", "m/m"],
    "percent": ["%"],
    "degC": ["°C", "Celsius"],
    "deg": ["°", "degree", "degrees"],
    "um": ["µm", "μm", "micron", "micrometer"],
    "L/min": ["l/min", "lpm", "liter/min"],
    "inch": ["in"],
}


@pytest.mark.parametrize("unit", SPELLED)
def test_every_spelling_of_a_unit_means_the_same(unit):
    for spelling in SPELLED[unit]:
        assert base_unit(spelling) == base_unit(unit), spelling


OF_PINT = {"ohm": "ohm", "rev": "turn", "gon": "grade", "micron": "micron", "1": ""}
OF_PINT |= {
    "PS": "metric_horsepower",
    "kgf": "kilogram_force",
    "VA": "V*A",
    "t": "tonne",
}
OF_PINT |= {"lpm": "l/min", "degC": "kelvin", "degF": "delta_degF"}
PRODUCTS = {"Nm": "N*m", "Vs": "V*s", "As": "A*s", "Ws": "W*s", "Nms": "N*m*s"}
PRODUCTS |= {"Nmm": "N*mm", "Ncm": "N*cm", "kgm": "kg*m", "kgm2": "kg*m**2"}
PRODUCTS |= {"kgcm2": "kg*cm**2", "kgmm2": "kg*mm**2", "gcm2": "g*cm**2"}
PRODUCTS |= {"gmm2": "g*mm**2", "L": "liter"}


def test_the_table_agrees_with_that_of_pint():
    """Names and prefixes; pint reads some as other things (Nm is its yarn count)."""
    names = [*unit_names.PREFIXED, *unit_names.PLAIN]
    for name in names:
        text = PRODUCTS.get(name) or OF_PINT.get(name, name)
        root = REGISTRY.Quantity(1, text).to_root_units()
        ours = base_unit(name)
        assert ours.factor * 1000.0**ours.kg == pytest.approx(root.m, rel=1e-8), name
        theirs = {str(n): e for n, e in root.unit_items()}
        exponents = [theirs.pop(base, 0) for base in PINTS_BASES]
        assert exponents == [getattr(ours, base) for base in unit_names.BASE], name
        assert not theirs


@pytest.mark.parametrize(
    ("misspelt", "meant"),
    [("rads", "rad"), ("Newtonmeter", "newton"), ("revs/mn", "min"), ("kOmh", "kOhm")],
)
def test_an_unknown_unit_names_the_nearest(misspelt, meant):
    with pytest.raises(UnitError, match=f"did you mean.*'{meant}'"):
        base_unit(misspelt)


@pytest.mark.parametrize("text", ["pu", "Nmm2", "grad", "furlongs", "k", "Nm2"])
def test_what_may_mean_two_things_is_no_unit(text):
    with pytest.raises(UnitError):
        base_unit(text)


def test_an_offset_does_not_apply_to_a_difference():
    degrees, kelvin = base_unit("degC"), base_unit("K")
    assert conversion(degrees, kelvin, relative=True) == (1.0, 0.0, False)


def test_the_docs_list_every_name_there_is():
    text = (Path(__file__).parents[2] / "docs/units.md").read_text()
    listed = set(re.findall(r"`([^`]+)`", text.partition("## Expressions")[0]))
    known = {*unit_names.PREFIXED, *unit_names.PLAIN, *unit_names._SPELLED}
    known |= {*unit_names._SPELLED.values(), *unit_names._PREFIXES}
    assert listed == known
