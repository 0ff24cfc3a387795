"""Times are exact and quantities convert as their units say."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.units import UnitError
from orchestrator.quantities.quantity import (
    DecimalFloat,
    Quantity,
    converter,
    parse_period,
    parse_quantity,
    parse_time,
    time_text,
)
from orchestrator.quantities.unit import product_unit, quotient_unit


@pytest.mark.parametrize(
    ("written", "seconds"),
    [
        ("1/20000", Fraction(1, 20_000)),
        ("0.36e-3", Fraction(36, 100_000)),
        ("50 us", Fraction(1, 20_000)),
        ("50 µs", Fraction(1, 20_000)),
        ("1/3 ms", Fraction(1, 3000)),
        ("20 kHz", Fraction(1, 20_000)),
        ("44100/2 Hz", Fraction(2, 44_100)),
        ("2 min", Fraction(120)),
        (".5", Fraction(1, 2)),
        (2, Fraction(2)),
        (DecimalFloat("0.1"), Fraction(1, 10)),
        (0.1, Fraction(1, 10)),
    ],
)
def test_a_time_is_read_by_its_decimal_text(written, seconds):
    assert parse_time(written) == seconds


@pytest.mark.parametrize(
    "written",
    ["", "abc", "1/0", "0 Hz", "nan", "inf", "1e9999", "5 parsec", True, None, [1]],
)
def test_what_is_no_time_is_refused(written):
    with pytest.raises(ValueError, match=r"time|zero|period|unit"):
        parse_time(written)


@pytest.mark.parametrize("written", ["0", "-1 us", 0])
def test_a_period_is_greater_than_zero(written):
    with pytest.raises(ValueError, match="greater than zero"):
        parse_period(written)


@given(st.fractions(min_value=Fraction(-(10**9)), max_value=Fraction(10**9)))
def test_the_text_of_a_time_reads_back_exactly(time):
    assert parse_time(time_text(time)) == time


@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=0, places=9))
def test_toml_numbers_keep_every_digit(number):
    assert parse_time(DecimalFloat(str(number))) == Fraction(number)


def test_a_quantity_converts_and_refuses_another_dimension():
    assert Quantity(1.5, "mm").to("um") == Quantity(1500.0, "um")
    assert Quantity(1.5, "mm").to(None) == Quantity(1.5, "mm")
    with pytest.raises(UnitError):
        Quantity(1.0, "V").to("um")


def test_units_multiply_and_divide_as_models_write_them():
    assert Quantity(2.0, product_unit("rad", "m/rad")).to("mm").value == 2000.0
    assert Quantity(6.0, quotient_unit("um", "V")).to("mm/V").value == pytest.approx(
        6e-3
    )
    assert product_unit("1", "V") == "V"
    assert product_unit("1", "1") == quotient_unit("V", "V") == "1"


def test_a_number_with_its_unit_is_read_from_text():
    assert parse_quantity("2.5e-3 m/rad") == Quantity(2.5e-3, "m/rad")
    assert parse_quantity("-4") == Quantity(-4.0)
    with pytest.raises(ValueError, match="number with a unit"):
        parse_quantity("m/rad")


@pytest.mark.parametrize(
    ("units", "said"),
    [(("um", "kg"), "um cannot become kg"), (("1", "V"), "a pure number cannot")],
)
def test_units_that_do_not_fit_are_named_as_they_were_written(units, said):
    with pytest.raises(UnitError, match=said):
        converter(*units)
