import pytest
from hypothesis import given
from hypothesis import strategies as st
from pint import UnitRegistry

from fmus.units import BaseUnit, UnitError, base_unit, conversion

NAMES = ["N", "V", "m", "mm", "um", "s", "rad", "deg", "kg", "g", "A", "Hz", "percent"]
REGISTRY = UnitRegistry()

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


def test_different_dimensions_are_refused():
    with pytest.raises(UnitError, match=r"kg.m.s-2 is not m"):
        conversion(base_unit("N"), base_unit("m"))


@pytest.mark.parametrize(
    "text", ["", "V.", "V..s", "(V", "V)", "dB", "bit", "degC.m", "degC2", "T_s"]
)
def test_what_is_no_unit_is_refused(text):
    with pytest.raises(UnitError, match="unit"):
        base_unit(text)
